// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "node_runtime.hpp"

namespace nacelle::runtime {

/// A component's place among those whom the broker tells of its graph.
class GraphPort final : public GraphWatchHandle {
 public:
  GraphPort(Graph& graph, GraphListener& listener) : graph_(graph), link_(graph.join(listener)) {}
  ~GraphPort() override { graph_.leave(link_); }
  GraphPort(const GraphPort&) = delete;
  GraphPort& operator=(const GraphPort&) = delete;

 private:
  Graph& graph_;
  const std::uint32_t link_;
};

/// A component's place among those whom the directory tells of its services.
class ServiceWatchPort final : public ServiceWatchHandle {
 public:
  ServiceWatchPort(ServiceGraph& graph, ServiceListener& listener) : graph_(graph), listener_(listener) {
    graph_.join(listener_);
  }
  ~ServiceWatchPort() override { graph_.leave(listener_); }
  ServiceWatchPort(const ServiceWatchPort&) = delete;
  ServiceWatchPort& operator=(const ServiceWatchPort&) = delete;

 private:
  ServiceGraph& graph_;
  ServiceListener& listener_;
};

/// The interface of a container to one Node. The runtime half may outlive the node, as long as the container needs it.
class Host : public NodeHost {
 public:
  /// `sim_clock`: of a node with use_sim_time; else null.
  Host(std::shared_ptr<NodeRuntime> node, SimClock* sim_clock)
      : node_(std::move(node)),
        sim_clock_(sim_clock),
        clock_(sim_clock != nullptr ? static_cast<const Clock&>(*sim_clock) : node_->commons().clock) {}
  const Clock& clock() const override { return clock_; }
  std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override { return node_->create_writer(spec); }
  std::unique_ptr<SubscriptionHandle> create_subscription(const EndpointSpec& spec, Taking taking,
                                                          MessageCallback callback,
                                                          const NodeRuntime::GroupPointer& group) override {
    return node_->create_subscription(spec, taking, callback, group);
  }
  std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, ReadyListener& listener) override {
    return node_->commons().broker.create_reader(spec, Taking::Share, &listener);
  }
  std::unique_ptr<GraphWatchHandle> watch_graph(GraphListener& listener) override {
    return std::make_unique<GraphPort>(node_->commons().broker, listener);
  }
  std::unique_ptr<ServiceWatchHandle> watch_services(ServiceListener& listener) override {
    return std::make_unique<ServiceWatchPort>(node_->commons().services, listener);
  }
  std::unique_ptr<StatusEventHandle> create_status_event(PlainCallback callback,
                                                         const NodeRuntime::GroupPointer& group) override {
    return node_->create_status_event(callback, group);
  }
  std::unique_ptr<TimerHandle> create_timer(TimerClock clock, Duration period, PlainCallback callback,
                                            const NodeRuntime::GroupPointer& group) override {
    return node_->create_timer(clock == TimerClock::OfNode ? sim_clock_ : nullptr, period, callback, group);
  }
  std::unique_ptr<ServiceHandle> create_service(const std::string& name, const msgs::MessageType& request,
                                                const msgs::MessageType& response, ServiceCallback callback,
                                                const NodeRuntime::GroupPointer& group) override {
    return node_->create_service(name, request, response, callback, group);
  }
  std::unique_ptr<ClientHandle> create_client(const std::string& name, const msgs::MessageType& request,
                                              const msgs::MessageType& response, ResponseCallback callback,
                                              const NodeRuntime::GroupPointer& group) override {
    return node_->create_client(name, request, response, callback, group);
  }
  NodeRuntime::GroupPointer create_callback_group(CallbackGroupType type) override {
    return node_->create_callback_group(type);
  }
  std::unique_ptr<FrameClaim> claim_frame(const std::string& parent, const std::string& child, FrameClaimKind kind,
                                          const nacelle::Place& origin) override {
    return node_->commons().frames.claim({node_->identity().fully_qualified(), parent, child, kind, origin});
  }
  std::shared_ptr<void> shared_object(const std::string& name, std::shared_ptr<void> (*make)()) override {
    auto& objects = node_->commons().shared_objects;
    if (auto object = (*objects.lock())[name]) return object;
    std::shared_ptr<void> made = make();  // not under the lock
    auto locked = objects.lock();
    auto& object = (*locked)[name];
    if (!object) object = std::move(made);
    return object;
  }
  DurationHistogram& create_histogram(const std::string& name) override { return node_->create_histogram(name); }
  void register_safe_stop(int descriptor, ByteView frame) override { node_->register_safe_stop(descriptor, frame); }
  void clear_safe_stop() override { node_->clear_safe_stop(); }
  void report_fault(std::string code, std::string text) override {
    node_->report_fault(std::move(code), std::move(text));
  }
  void open_fault(std::string code, std::string text) override { node_->open_fault(code, text); }
  void close_fault(const std::string& code) override { node_->close_fault(code); }
  void set_active(bool active) override { node_->set_active(active); }

 private:
  const std::shared_ptr<NodeRuntime> node_;
  SimClock* const sim_clock_;
  const Clock& clock_;
};

}  // namespace nacelle::runtime
