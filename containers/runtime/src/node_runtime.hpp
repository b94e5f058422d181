// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "frames.hpp"
#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/host/node_host.hpp"
#include "nacelle/node/container_facts.hpp"
#include "nacelle/node/motion_stops.hpp"
#include "nacelle/node/network_facts.hpp"
#include "nacelle/runtime/broker.hpp"
#include "nacelle/runtime/executor.hpp"
#include "patience.hpp"
#include "safe_stop.hpp"
#include "services.hpp"
#include "sim_clock.hpp"

namespace nacelle::runtime {

/// The data that all nodes of a container share.
struct Commons {
  /// `container`: its full name.
  Commons(const Clock& c, Watching watching, std::string container)
      : clock(c),
        broker(c, watching),
        motion_stops(std::make_shared<MotionStops>()),
        facts(std::make_shared<ContainerFacts>(std::move(container))) {
    shared_objects.lock()->emplace(kMotionStopsName, motion_stops);
    shared_objects.lock()->emplace(kContainerFactsName, facts);
    shared_objects.lock()->emplace(kNetworkFactsName, make_network_facts());
    shared_objects.lock()->emplace(kClockSkewsName, clock_skews);
  }
  /// The clock of nodes with use_sim_time.
  [[nodiscard]] SimClock& simulated() {
    auto sim = sim_clock.lock();
    if (!*sim) *sim = std::make_unique<SimClock>(clock, broker);
    return **sim;
  }
  const Clock& clock;
  Broker broker;
  Guarded<std::unique_ptr<SimClock>> sim_clock;  // made with the first node that uses it
  ServiceDirectory services;
  FrameRegistry frames;
  Guarded<std::map<std::string, std::shared_ptr<void>>> shared_objects;
  const std::shared_ptr<MotionStops> motion_stops;  // in shared_objects, like the next two
  const std::shared_ptr<ContainerFacts> facts;
  const std::shared_ptr<void> clock_skews = make_clock_skews();
};

/// A node's host in the container. Ownership: the node. The destructor withdraws everything that the node registered
/// with the container.
class NodeRuntime {
 public:
  using OnFault = NodeGroups::OnFault;
  using GroupPointer = std::shared_ptr<nacelle::CallbackGroup>;
  /// `measured`: record the durations of its services for report_callbacks().
  NodeRuntime(Commons& commons, NodeIdentity identity, Executor& executor, OnFault on_fault, bool measured = true);
  ~NodeRuntime();

  [[nodiscard]] std::unique_ptr<Writer> create_writer(const EndpointSpec& spec);
  [[nodiscard]] std::unique_ptr<SubscriptionHandle> create_subscription(const EndpointSpec& spec, Taking taking,
                                                                        MessageCallback callback,
                                                                        const GroupPointer& group);
  [[nodiscard]] std::unique_ptr<StatusEventHandle> create_status_event(PlainCallback callback,
                                                                       const GroupPointer& group);
  [[nodiscard]] std::unique_ptr<TimerHandle> create_timer(SimClock* clock, Duration period, PlainCallback callback,
                                                          const GroupPointer& group);  // null: the monotonic clock
  [[nodiscard]] std::unique_ptr<ServiceHandle> create_service(const std::string& name, const msgs::MessageType& request,
                                                              const msgs::MessageType& response,
                                                              ServiceCallback callback, const GroupPointer& group);
  [[nodiscard]] std::unique_ptr<ClientHandle> create_client(const std::string& name, const msgs::MessageType& request,
                                                            const msgs::MessageType& response,
                                                            ResponseCallback callback, const GroupPointer& group);
  [[nodiscard]] GroupPointer create_callback_group(CallbackGroupType type);
  [[nodiscard]] DurationHistogram& create_histogram(const std::string& name);
  void register_safe_stop(int descriptor, ByteView frame) { safe_stop_.set(descriptor, frame); }
  void clear_safe_stop() { safe_stop_.clear(); }
  void report_fault(std::string code, std::string text);
  /// Sets the receiver of open faults; call before the node is made.
  struct OpenFaults {
    std::function<void(const std::string& code, const std::string& text, const std::string& callback)> open;
    std::function<void(const std::string& code)> close;
  };
  void set_open_faults(OpenFaults open_faults) { open_faults_ = std::move(open_faults); }
  void open_fault(const std::string& code, const std::string& text);
  void close_fault(const std::string& code);
  void set_active(bool active);

  /// Call once the node is constructed: its callbacks may run from now on.
  void open() { executor().open(groups_); }
  /// Prevents further callbacks of all its groups. Returns false if one still runs at the deadline.
  [[nodiscard]] bool close(MonotonicTime deadline) { return executor().close(groups_, deadline); }

  /// Runs something on the component's executor while no callback of the node runs, and waits for it. Returns false if
  /// it has not ended by the deadline, or cannot run any more; it may still run then, so `what` must not refer to the
  /// caller's stack frame. A callback that would wait for itself only times out: see Executor::why_not_wait_for().
  /// `name` is a literal that identifies the run in reports: "on_configure".
  [[nodiscard]] bool run_and_wait(const char* name, std::function<void()> what, const Deadline& deadline);
  /// The same without waiting; a run that takes longer is a fault (HUNG). `patience` outlives the node.
  void post(const char* name, const Patience& patience, std::function<void()> what);
  /// Abandons a component whose code does not return: it receives and sends nothing any more, its frames become free
  /// for other nodes, and callers that wait for its services are notified that there will be no answer.
  void withdraw();
  /// Withdraws the services only. Used by NodeFace, which offers services without a Node.
  void withdraw_services();
  void write_safe_stop() const noexcept { safe_stop_.write(); }
  /// Returns whether it has ever registered a stop frame, so it moves something.
  [[nodiscard]] bool is_actuator() const { return safe_stop_.was_ever_set(); }
  /// Sets the library that it comes from, for a crash record.
  void set_image(const std::string& image) { safe_stop_.set_image(image); }
  [[nodiscard]] Executor& executor() { return groups_.executor(); }
  [[nodiscard]] const NodeGroups& groups() const { return groups_; }
  [[nodiscard]] const NodeIdentity& identity() const { return identity_; }
  [[nodiscard]] const std::atomic<bool>& active() const { return active_; }
  [[nodiscard]] bool is_measured() const { return measured_; }
  void report_histograms(std::vector<HistogramReport>& out, std::size_t& used) const;
  void report_callbacks(std::vector<CallbackReport>& out, std::size_t& used) const;
  void report_services(std::vector<ServiceReport>& out) const;
  void report_load(LoadReport& out) const { groups_.executor().report_load(groups_, out); }
  [[nodiscard]] Commons& commons() { return commons_; }

  /// A callback that is reported, and notified of the lifecycle gate.
  class Port {
   public:
    virtual ~Port() = default;
    virtual void set_active(bool active) = 0;
    virtual void report(CallbackReport& row) const = 0;
    /// Returns false for a port that does not belong to a service.
    [[nodiscard]] virtual bool describe(ServiceReport&) const { return false; }
  };
  // Ports call these to register and unregister themselves.
  void enroll(Port& port);
  void leave(Port& port);
  void enroll(const std::string& name, ServerPort& server);
  void leave(ServerPort& server);
  /// Returns the requested group, or the node's default group. Errors: std::runtime_error for another node's.
  [[nodiscard]] std::shared_ptr<CallbackGroup> group_of(const GroupPointer& wanted, const char* what) const;

 private:
  struct NamedHistogram {
    std::string name;
    DurationHistogram histogram;
  };

  /// Returns what runs on this thread, for display.
  [[nodiscard]] std::string who_runs_here() const;

  Commons& commons_;
  const NodeIdentity identity_;
  const bool measured_;
  const OnFault on_fault_;
  OpenFaults open_faults_;
  NodeGroups groups_;
  const std::shared_ptr<CallbackGroup> own_group_;
  std::atomic<bool> active_{true};
  mutable Mutex mutex_;
  std::vector<Port*> ports_ NACELLE_GUARDED_BY(mutex_);
  std::vector<std::pair<std::string, ServerPort*>> servers_ NACELLE_GUARDED_BY(mutex_);
  std::deque<NamedHistogram> histograms_ NACELLE_GUARDED_BY(mutex_);  // a deque: references stay
  SafeStop safe_stop_;                                                // after groups_, whose name it shows
};

}  // namespace nacelle::runtime
