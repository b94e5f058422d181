// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "frames.hpp"
#include "nacelle/node/host.hpp"
#include "nacelle/runtime/broker.hpp"
#include "nacelle/runtime/executor.hpp"
#include "services.hpp"

namespace nacelle::runtime {

/// What all nodes of a container share.
struct Commons {
  explicit Commons(const Clock& c) : clock(c), broker(c) {}
  const Clock& clock;
  Broker broker;
  ServiceDirectory services;
  FrameRegistry frames;
  Guarded<std::map<std::string, std::shared_ptr<void>>> shared_objects;
};

/// The bytes that stop a component's hardware, readable by a signal handler: fixed memory, published by one atomic.
struct SafeStop {
  std::atomic<int> descriptor{-1};
  std::size_t length = 0;
  std::array<std::uint8_t, 64> frame{};
};

/// A node's host in the container. Ownership: the node's; what it lent to the container is withdrawn in the destructor.
class NodeRuntime {
 public:
  using OnFault = std::function<void(std::string code, std::string text)>;
  NodeRuntime(Commons& commons, NodeIdentity identity, Executor& executor, OnFault on_fault);
  ~NodeRuntime();

  [[nodiscard]] std::unique_ptr<Writer> create_writer(const EndpointSpec& spec);
  [[nodiscard]] std::unique_ptr<SubscriptionHandle> create_subscription(const EndpointSpec& spec, Taking taking,
                                                                        MessageCallback callback);
  [[nodiscard]] std::unique_ptr<TimerHandle> create_timer(Duration period, PlainCallback callback);
  [[nodiscard]] std::unique_ptr<ServiceHandle> create_service(const std::string& name, const msgs::MessageType& request,
                                                              const msgs::MessageType& response,
                                                              ServiceCallback callback);
  [[nodiscard]] std::unique_ptr<ClientHandle> create_client(const std::string& name, const msgs::MessageType& request,
                                                            const msgs::MessageType& response,
                                                            ResponseCallback callback);
  [[nodiscard]] DurationHistogram& create_histogram(const std::string& name);
  void register_safe_stop(int descriptor, ByteView frame);
  void clear_safe_stop();
  void report_fault(std::string code, std::string text) { on_fault_(std::move(code), std::move(text)); }
  void set_active(bool active);
  /// The node is made: its callbacks may run. Until then what becomes ready waits.
  void open() { group_.executor().open(group_); }

  /// Runs something on the component's executor and waits for it. Returns false if it has not ended by the deadline; it may
  /// still run then, so `what` must not refer to the caller's frame.
  [[nodiscard]] bool run_and_wait(std::function<void()> what, MonotonicTime deadline);
  /// The same without waiting.
  void post(std::function<void()> what);
  /// For a component whose code does not return: it takes and sends nothing any more, its frames are free for others, and who
  /// waits for an answer of its services is told that there will be none.
  void withdraw();
  void write_safe_stop() const noexcept;
  [[nodiscard]] CallbackGroup& group() { return group_; }
  [[nodiscard]] const NodeIdentity& identity() const { return identity_; }
  [[nodiscard]] const std::atomic<bool>& active() const { return active_; }
  void report_histograms(std::vector<HistogramReport>& out, std::size_t& used) const;
  [[nodiscard]] Commons& commons() { return commons_; }

  // Readers enter and leave the lifecycle gate by themselves.
  void enroll(Reader& reader);
  void leave(Reader& reader);
  void enroll(const std::string& name, ServerPort& server);
  void leave(ServerPort& server);

 private:
  struct NamedHistogram {
    std::string name;
    DurationHistogram histogram;
  };

  Commons& commons_;
  const NodeIdentity identity_;
  const OnFault on_fault_;
  CallbackGroup group_;
  std::atomic<bool> active_{true};
  mutable std::mutex mutex_;  // the lists below
  std::vector<Reader*> readers_;
  std::vector<std::pair<std::string, ServerPort*>> servers_;
  std::deque<NamedHistogram> histograms_;  // a deque: references stay
  SafeStop safe_stop_;
};

}  // namespace nacelle::runtime
