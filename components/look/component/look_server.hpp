// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "look/component/asset_folders.hpp"
#include "look/component/parameter_questions.hpp"
#include "look/component/robot_requests.hpp"
#include "look/component/service_list.hpp"
#include "look/component/topic_streams.hpp"
#include "look/model/access.hpp"
#include "look/model/outbox.hpp"
#include "look/port/web_server.hpp"
#include "look/protocol/client_message.hpp"
#include "rcl_interfaces/msg/parameter_event.hpp"

namespace nacelle::look {

/// Speaks the Foxglove WebSocket protocol with viewers, on a thread of its own at low priority.
///
/// The server watches the container only while a viewer is connected. Threads: construct and destroy on the component's executor.
class LookServer final : private WebHandler {
 public:
  struct Options {
    Access::Options access;
    WebServer::Options web;
    std::uint64_t bytes_per_second = 0;  ///< For each viewer; 0: as many as the connection takes.
    std::vector<std::string> asset_folders;
    std::string name;       ///< Of the robot, for people.
    std::string container;  ///< Its full name, for the page; empty: unknown.
    bool has_sim_time = false;
  };
  [[nodiscard]] static Result<std::unique_ptr<LookServer>, Problem> start(Node& node, GenericTopics topics,
                                                                          GenericServices services, Options options);
  LookServer(const LookServer&) = delete;
  LookServer& operator=(const LookServer&) = delete;
  ~LookServer() override;

  [[nodiscard]] std::uint16_t port() const { return web_->port(); }

 private:
  struct Out {
    std::string topic, type, encoding;
  };
  struct Viewer {
    Viewer(Right r, std::uint64_t bytes_per_second) : right(r), outbox(bytes_per_second) {}
    Right right;
    Outbox outbox;
    std::map<std::uint32_t, std::uint32_t> subscriptions;          // the viewer's number -> channel
    std::set<std::pair<std::uint32_t, std::uint32_t>> by_channel;  // the same, the other way round
    std::map<std::uint32_t, Out> publications;
    ConnectionGraph graph;  // what it knows
    bool watches_graph = false;
    bool watches_all_parameters = false;
    std::set<std::string> watched_parameters;
    std::size_t calls = 0;            // that have no answer yet
    std::uint32_t requests_left = 0;  // until the next tick
  };
  LookServer(Node& node, GenericTopics topics, GenericServices services, Options options);

  // WebHandler
  [[nodiscard]] bool takes_host(std::string_view host) override { return access_.is_host_allowed(host); }
  [[nodiscard]] unsigned refusal_of(const Handshake& handshake) override;
  void on_open(ViewerId id, const Handshake& handshake) override;
  [[nodiscard]] bool on_message(ViewerId id, bool is_binary, ByteView bytes) override;
  void on_close(ViewerId id) override;
  [[nodiscard]] bool next(ViewerId id, bool& is_binary, Bytes& out) override;
  void on_tick() override;

  void take(ViewerId id, Viewer& viewer, const Subscribe& message);
  void take(ViewerId id, Viewer& viewer, const Unsubscribe& message);
  void take(ViewerId id, Viewer& viewer, const Advertise& message);
  void take(ViewerId id, Viewer& viewer, const Unadvertise& message);
  void take(ViewerId id, Viewer& viewer, const GetParameters& message);
  void take(ViewerId id, Viewer& viewer, const SetParameters& message);
  void take(ViewerId id, Viewer& viewer, const WatchParameters& message);
  void take(ViewerId id, Viewer& viewer, const WatchGraph& message);
  void take(ViewerId id, Viewer& viewer, const FetchAsset& message);
  void take(ViewerId id, Viewer& viewer, const Publication& message);
  void take(ViewerId id, Viewer& viewer, const ServiceCall& message);

  void follow_changes();
  void tell_graph();
  void watch_parameter_events();
  void on_parameter_event(const rcl_interfaces::msg::ParameterEvent& event);
  void say(ViewerId id, Viewer& viewer, std::string text);
  void send(ViewerId id, Viewer& viewer, Bytes frame);
  void warn(ViewerId id, Viewer& viewer, const Problem& problem);
  /// Sends it if the viewer is still there. Threads: any.
  void say_later(ViewerId id, std::string text);
  void refuse_call(ViewerId id, Viewer& viewer, const ServiceCall& call, const Problem& problem);
  [[nodiscard]] ParameterQuestions::Take parameter_answer(ViewerId id, const std::string& question);
  /// Has it done on the executor. Returns what is wrong if it is not.
  [[nodiscard]] std::optional<Problem> order(Viewer& viewer, std::function<void()> work, std::uint32_t requests = 1);
  void order_or_warn(ViewerId id, Viewer& viewer, std::function<void()> work, std::uint32_t requests = 1);
  [[nodiscard]] std::uint64_t now_ns() const;

  Node& node_;
  GenericTopics topics_;
  GenericServices graph_;
  const Options options_;
  const Access access_;
  const AssetFolders assets_;
  RobotRequests requests_;
  ParameterQuestions questions_;                                                         // of the executor
  std::shared_ptr<Subscription<rcl_interfaces::msg::ParameterEvent>> parameter_events_;  // of the executor
  std::atomic<bool> questions_wait_ = false;

  // The server's thread's own.
  std::map<ViewerId, std::unique_ptr<Viewer>> viewers_;
  std::unique_ptr<TopicStreams> streams_;  // while there is a viewer
  std::unique_ptr<ServiceList> services_;
  bool is_ending_ = false, graph_changed_ = false, watches_parameters_ = false;
  std::uint32_t ticks_ = 0;

  std::unique_ptr<WebServer> web_;
  std::thread thread_;
};

}  // namespace nacelle::look
