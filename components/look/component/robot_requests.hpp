// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "look/port/web_server.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/node/generic_services.hpp"
#include "nacelle/node/generic_topics.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::look {

/// What viewers ask of the robot: messages that they publish, and calls of services. It is done on the component's executor, where a node
/// may do it; the answers come on the server's thread.
///
/// Threads: construct and destroy on the executor; post() any; everything else on the executor.
class RobotRequests {
 public:
  /// Takes the response of a call; null: there will be none. Threads: the executor.
  using TakeResponse = std::function<void(const void* response)>;

  RobotRequests(Node& node, GenericTopics topics, GenericServices services);
  ~RobotRequests();
  RobotRequests(const RobotRequests&) = delete;
  RobotRequests& operator=(const RobotRequests&) = delete;

  /// Runs it on the executor. Returns false if too much waits there: the robot is busy.
  bool post(std::function<void()> work);

  /// A topic that a viewer publishes. Errors: the type is not installed.
  [[nodiscard]] Result<void, Problem> open_writer(ViewerId viewer, std::uint32_t channel, const std::string& topic,
                                                  const std::string& type);
  /// `encoding`: "cdr" or "json". Errors: no message of this type.
  [[nodiscard]] Result<void, Problem> publish(ViewerId viewer, std::uint32_t channel, const std::string& encoding,
                                              ByteView data);
  void close_writer(ViewerId viewer, std::uint32_t channel);
  void close_writers(ViewerId viewer);

  /// Calls a service of the container. `take` is called once, if the service answers or goes away.
  void call(const std::string& service, const msgs::MessageType& request_type, const msgs::MessageType& response_type,
            msgs::AnyMessage request, TakeResponse take);

 private:
  struct Out {
    std::string topic;
    const msgs::MessageType* type = nullptr;
    std::shared_ptr<Writer> writer;
  };
  struct ServiceClient;
  void work();

  GenericTopics topics_;
  GenericServices graph_;
  msgs::TypeLibrary types_;
  std::map<std::pair<ViewerId, std::uint32_t>, Out> writers_;
  /// An emergency stop stays set when its viewer goes: a reader that comes later hears of it.
  std::map<std::string, std::shared_ptr<Writer>> stops_;
  std::map<std::string, std::unique_ptr<ServiceClient>> clients_;
  std::shared_ptr<WakeUp> wake_up_;

  Mutex mutex_;
  std::vector<std::function<void()>> posts_ NACELLE_GUARDED_BY(mutex_);
};

/// Whether a topic is an emergency stop, in any namespace.
[[nodiscard]] bool is_emergency_stop(const std::string& topic, const std::string& type);
/// Whether these bytes set the emergency stop (they do not release it).
[[nodiscard]] bool sets_emergency_stop(const std::string& encoding, ByteView data);

}  // namespace nacelle::look
