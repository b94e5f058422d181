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
/// Copies share the network node of this process.
/// Threads: one.
class Whom {
 public:
  Whom();

  /// The value of --container.
  std::string container;

  /// Adds --remote, --domain, --network and --spin-time.
  void add_options(Command& command);
  [[nodiscard]] bool is_remote() const;
  /// Returns a command with the same target, for messages: "`nacelle topic list --remote`" for "topic list".
  [[nodiscard]] std::string command(const std::string& words) const;
  /// Returns the problem of an invalid combination of options, or nothing.
  [[nodiscard]] std::optional<Problem> misuse() const;
  /// Returns a connection to the network's nodes. The first one joins the network. Errors: as
  /// remote::RemoteNetwork::join().
  [[nodiscard]] Result<control::Client, Problem> connect_remotely(
      std::vector<std::filesystem::path> message_folders) const;

 private:
  struct Remote;
  std::shared_ptr<Remote> remote_;
};

}  // namespace nacelle::cli
