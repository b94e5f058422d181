// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <type_description_interfaces/srv/get_type_description.hpp>
#include <vector>

#include "nacelle/msgs/type_library.hpp"
#include "nacelle/node/network_facts.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::record {

/// Finds the topics that only other programs publish, and the type with which each can be recorded.
///
/// That is the installed type, if its hash is the announced one. Otherwise it is one whose messages are their bytes: its definition is what one of
/// the publishers' nodes answers (~/get_type_description), or empty if none answers in time.
/// Threads: the component's executor.
class RemoteTopics {
 public:
  struct Options {
    std::function<bool(const std::string& topic)> takes;
    /// Called for each topic when its type is known, and again when what other programs publish has changed.
    std::function<void(const std::string& topic, const msgs::MessageType& type, const std::vector<QoS>& offered)> add;
    Duration patience = 3s;  ///< How long a definition is waited for. Messages that come meanwhile are not recorded.
  };
  /// `node` and `clock` outlive it.
  RemoteTopics(Node& node, const Clock& clock, std::shared_ptr<const NetworkFacts> facts, Options options);
  RemoteTopics(const RemoteTopics&) = delete;
  RemoteTopics& operator=(const RemoteTopics&) = delete;
  ~RemoteTopics();

  /// To be called several times a second.
  void look();

 private:
  using GetTypeDescription = type_description_interfaces::srv::GetTypeDescription;
  using Key = std::tuple<std::string, std::string, std::string>;  // topic, type, hash
  struct Found {
    RemoteTopic topic;
    const msgs::MessageType* type = nullptr;  // null: its definition is asked for
    MonotonicTime until{};
    std::string asked;  // the node whose client it is
    std::shared_ptr<Client<GetTypeDescription>> client;
    bool is_sent = false;
  };
  void take(RemoteTopic topic);
  void ask(Found& found);
  void settle(Found& found, const std::string& definition);

  Node& node_;
  const Clock& clock_;
  const std::shared_ptr<const NetworkFacts> facts_;
  const Options options_;
  std::uint64_t version_ = 0;
  msgs::TypeLibrary types_;
  std::map<Key, Found> found_;
};

/// Returns the text of a recording's schema ("ros2msg") that a node's answer makes: the type's own text, then those of the types in it, each once. Empty if
/// a text is missing, is no .msg, or is longer than a definition can be: other programs write them.
[[nodiscard]] std::string definition_in(const type_description_interfaces::srv::GetTypeDescription::Response& response,
                                        const std::string& type);

}  // namespace nacelle::record
