// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <thread>
#include <vector>

#include "control/client.hpp"
#include "control/server.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "remote/remote_network.hpp"
#include "requests/late_reply.hpp"

namespace nacelle::remote {

/// Serves requests for the nodes of the network as a container does, in this process, over private sockets.
///
/// SIGINT, SIGTERM and SIGHUP without a handler still end the process, but it leaves the network first, so that peers
/// do not have to wait for this node's lease.
/// Threads: runs a thread "remote"; all members from one thread.
class RemoteRequests {
 public:
  /// Joins the network. One object per process at a time. Errors: as RemoteNetwork::join().
  [[nodiscard]] static Result<std::unique_ptr<RemoteRequests>, Problem> open(const RemoteOptions& options);
  RemoteRequests(const RemoteRequests&) = delete;
  RemoteRequests& operator=(const RemoteRequests&) = delete;
  /// Leaves the network.
  ~RemoteRequests();

  /// Returns a new connection to the server.
  [[nodiscard]] Result<control::Client, Problem> connect();

 private:
  RemoteRequests(std::unique_ptr<RemoteNetwork> network, Duration spin_time);
  void run();

  std::unique_ptr<RemoteNetwork> network_;
  const Duration spin_time_;
  Bell stop_, came_;
  Guarded<std::vector<std::unique_ptr<control::Connection>>> coming_;
  std::thread thread_;
};

}  // namespace nacelle::remote
