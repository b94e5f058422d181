// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "remote/remote_network.hpp"
#include "requests/request_server.hpp"

namespace nacelle::remote {

/// Answers the requests of the command line for ROS 2 nodes of the network, in the form in which a container answers
/// them for its components. A request waits for discovery; the answer of a service call follows later.
/// Threads: the server's.
class RemoteNodes final : public requests::Respondent {
 public:
  explicit RemoteNodes(RemoteNetwork& network) : network_(network) {}

  [[nodiscard]] const Clock& clock() const override { return network_.clock(); }
  [[nodiscard]] requests::Answer answer(const std::string& verb, const nlohmann::json& request) override;
  [[nodiscard]] Result<std::unique_ptr<requests::TopicTap>, Problem> tap(const requests::TapWish& wish) override;
  [[nodiscard]] std::optional<Problem> problem_of(const std::string& topic) const override {
    return network_.problem_of(topic);
  }
  /// Handles OpenWriter, Publish and Stats, as a container's control thread does.
  void take_frame(control::Connection& from, const control::Frame& frame) override;
  void has_left(const control::Connection& connection) override;

 private:
  struct OpenWriter {
    const control::Connection* owner = nullptr;
    std::string topic;
    const msgs::MessageType* type = nullptr;
    std::unique_ptr<Writer> writer;
  };
  [[nodiscard]] Result<const msgs::MessageType*, Problem> type_of(
      const requests::TapWish& wish, const std::vector<transport_dds::RemoteEndpoint>& ends);
  [[nodiscard]] Result<std::uint16_t, std::string> open_writer(control::NamePair names,
                                                               const control::Connection& owner);
  /// Returns nothing, or the reason for the refusal.
  [[nodiscard]] std::optional<std::string> publish(const control::Publication& publication);

  RemoteNetwork& network_;
  std::vector<OpenWriter> writers_;
};

/// Returns the full name of a remote node. Waits for it at most for the spin time. Errors: no such node; several nodes.
[[nodiscard]] Result<std::string, Problem> node_named(RemoteNetwork& network, const std::string& name);
/// Returns whether a service is known to be offered. `service`: its full name, such as "/lidar/get_state".
[[nodiscard]] bool offers(const RemoteNetwork& network, const std::string& service);
/// Returns the container of that name, or for an empty name the only one. Waits for it at most for the spin time.
/// Errors: no container; several containers.
[[nodiscard]] Result<std::string, Problem> container_named(RemoteNetwork& network, const std::string& name);
/// Returns the Nacelle container in the same process as a node, if known; otherwise an empty text.
[[nodiscard]] std::string container_of(const RemoteNetwork& network, const std::string& node);

}  // namespace nacelle::remote
