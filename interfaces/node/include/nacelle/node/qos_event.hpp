// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "nacelle/base/log.hpp"
#include "nacelle/host/node_host.hpp"

namespace nacelle {

// rmw's status structs, as rclcpp's event callbacks get them: totals, and what has changed since the last call.

struct QOSDeadlineOfferedInfo {
  std::uint64_t total_count = 0, total_count_change = 0;
};
using QOSDeadlineRequestedInfo = QOSDeadlineOfferedInfo;
using QOSLivelinessLostInfo = QOSDeadlineOfferedInfo;
using QOSMessageLostInfo = QOSDeadlineOfferedInfo;
struct QOSLivelinessChangedInfo {
  std::uint32_t alive_count = 0, not_alive_count = 0;
  std::int32_t alive_count_change = 0, not_alive_count_change = 0;
};
struct QOSOfferedIncompatibleQoSInfo {
  std::uint64_t total_count = 0, total_count_change = 0;
  std::string last_policy_kind;  ///< "reliability", "deadline", ...
  std::string text;              ///< Both endpoints, policy, both values and the change that mends it.
};
using QOSRequestedIncompatibleQoSInfo = QOSOfferedIncompatibleQoSInfo;
using IncompatibleTypeInfo = QOSOfferedIncompatibleQoSInfo;
struct MatchedInfo {
  std::uint64_t total_count = 0, total_count_change = 0;
  std::uint32_t current_count = 0;
  std::int32_t current_count_change = 0;
};

/// Run on the node's executor (in the endpoint's callback group), also while the node is not active. Several changes may come
/// as one call. An empty one is not called.
struct PublisherEventCallbacks {
  std::function<void(QOSDeadlineOfferedInfo&)> deadline_callback;
  std::function<void(QOSLivelinessLostInfo&)> liveliness_callback;
  std::function<void(QOSOfferedIncompatibleQoSInfo&)> incompatible_qos_callback;
  std::function<void(IncompatibleTypeInfo&)> incompatible_type_callback;
  std::function<void(MatchedInfo&)> matched_callback;

  [[nodiscard]] bool any() const {
    return deadline_callback || liveliness_callback || incompatible_qos_callback || incompatible_type_callback ||
           matched_callback;
  }
};

/// The same for a subscription. Without callbacks of their own, incompatible publishers are logged as warnings.
struct SubscriptionEventCallbacks {
  std::function<void(QOSDeadlineRequestedInfo&)> deadline_callback;
  std::function<void(QOSLivelinessChangedInfo&)> liveliness_callback;
  std::function<void(QOSRequestedIncompatibleQoSInfo&)> incompatible_qos_callback;
  std::function<void(IncompatibleTypeInfo&)> incompatible_type_callback;
  std::function<void(QOSMessageLostInfo&)> message_lost_callback;
  std::function<void(MatchedInfo&)> matched_callback;
};

namespace detail {

/// Turns an endpoint's status into callbacks. Lives in the component; outlives its endpoint. Threads: the executor's.
class EndpointEvents {
 public:
  virtual ~EndpointEvents() = default;
  EndpointEvents(const EndpointEvents&) = delete;
  EndpointEvents& operator=(const EndpointEvents&) = delete;
  [[nodiscard]] StatusListener* listener() { return &event_->listener(); }

 protected:
  EndpointEvents(NodeHost& host, const CallbackGroup::SharedPtr& group)
      : event_(host.create_status_event({&EndpointEvents::run, this}, group)) {}
  void end() { event_.reset(); }
  [[nodiscard]] virtual bool read(EndpointStatus& status) const = 0;
  virtual void compare(const EndpointStatus& now, const EndpointStatus& before) = 0;

 private:
  static void run(void* context);
  std::unique_ptr<StatusEventHandle> event_;
  EndpointStatus last_;
};

class PublisherEvents final : public EndpointEvents {
 public:
  PublisherEvents(NodeHost& host, const CallbackGroup::SharedPtr& group, PublisherEventCallbacks callbacks)
      : EndpointEvents(host, group), callbacks_(std::move(callbacks)) {}
  ~PublisherEvents() override { end(); }
  /// Reports events that occurred while the writer was created.
  void watch(const Writer& writer);

 private:
  bool read(EndpointStatus& status) const override;
  void compare(const EndpointStatus& now, const EndpointStatus& before) override;
  const PublisherEventCallbacks callbacks_;
  std::atomic<const Writer*> writer_{nullptr};
};

class SubscriptionEvents final : public EndpointEvents {
 public:
  SubscriptionEvents(NodeHost& host, const CallbackGroup::SharedPtr& group, SubscriptionEventCallbacks callbacks,
                     const Logger& logger)
      : EndpointEvents(host, group), callbacks_(std::move(callbacks)), logger_(logger) {}
  ~SubscriptionEvents() override { end(); }
  void watch(const Reader& reader);

 private:
  bool read(EndpointStatus& status) const override;
  void compare(const EndpointStatus& now, const EndpointStatus& before) override;
  const SubscriptionEventCallbacks callbacks_;
  const Logger& logger_;
  std::atomic<const Reader*> reader_{nullptr};
};

}  // namespace detail
}  // namespace nacelle
