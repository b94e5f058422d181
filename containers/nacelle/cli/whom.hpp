// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "control/client.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::cli {

/// The target of a command: a container of this machine, or with --remote the nodes of ROS 2's network.
///
/// Copies share the one node that this process is on the network.
/// Threads: one.
class Whom {
 public:
  Whom();

  /// --container
  std::string container;

  /// --remote, --domain, --network and --spin-time.
  void add_options(Command& command);
  [[nodiscard]] bool is_remote() const;
  /// Returns a command with the same target, for messages: "`nacelle topic list --remote`" for "topic list".
  [[nodiscard]] std::string command(const std::string& words) const;
  /// Returns what is wrong with the combination of options.
  [[nodiscard]] std::optional<Problem> misuse() const;
  /// Joins the network with the first connection. Errors: as remote::RemoteNetwork::join().
  [[nodiscard]] Result<control::Client, Problem> connect_remotely(
      std::vector<std::filesystem::path> message_folders) const;

 private:
  struct Remote;
  std::shared_ptr<Remote> remote_;
};

}  // namespace nacelle::cli
