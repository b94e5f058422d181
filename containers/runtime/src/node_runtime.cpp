// SPDX-License-Identifier: Apache-2.0
#include "node_runtime.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "reader_queue.hpp"

namespace nacelle::runtime {
namespace {

// The data of every port beside its callback.
class PortBase : public NodeRuntime::Port {
 protected:
  PortBase(NodeRuntime& node, const NodeRuntime::GroupPointer& group, const char* kind, std::string name)
      : node_(node), member_of_(node.group_of(group, kind)), kind_(kind), name_(std::move(name)) {}

  void fill(CallbackReport& row, const CallbackStats& stats, const DurationHistogram& latency) const {
    row.node = node_.groups().name();
    row.kind = kind_;
    row.name = name_;
    row.count = stats.duration.count();
    row.skipped = 0;
    row.duration_p50 = stats.duration.quantile(0.5);
    row.duration_p99 = stats.duration.quantile(0.99);
    row.duration_max = stats.duration.max();
    row.duration_total = stats.duration.total();
    row.latency_p50 = latency.quantile(0.5);
    row.latency_p99 = latency.quantile(0.99);
    row.latency_max = latency.max();
  }
  NodeRuntime& node_;
  const std::shared_ptr<CallbackGroup> member_of_;
  const char* const kind_;
  const std::string name_;
};

class SubscriptionPort final : public SubscriptionHandle, private PortBase, private Executable {
 public:
  SubscriptionPort(NodeRuntime& node, EndpointSpec spec, Taking taking, MessageCallback callback,
                   const NodeRuntime::GroupPointer& group)
      : PortBase(node, group, "subscription", spec.topic),
        Executable(*member_of_),
        taking_(taking),
        is_reentrant_(member_of_->type() == CallbackGroupType::Reentrant),
        callback_(callback) {
    keep_stats_in(stats_);
    describe_as(PortBase::kind_, name_.c_str());
    spec.gate = &node.active();
    reader_ = node.commons().broker.create_reader(spec, taking, static_cast<Executable&>(*this));
    node_.enroll(*this);
  }
  ~SubscriptionPort() override {
    node_.leave(*this);
    node_.executor().forget(*this);
  }
  Reader& reader() override { return *reader_; }

 private:
  void execute(MonotonicTime now) override {
    Block* const block = reader_->take();
    if (block == nullptr) return;
    if (is_reentrant_ && reader_->has_waiting()) on_ready();
    execute_with(*block, now);
  }
  void execute_with(Block& block, MonotonicTime now) override {
    if (is_reentrant_) [[unlikely]] {
      // Such a callback may run in parallel with itself, and a histogram has one writer.
      const LockGuard lock(noting_);
      inbox().note_latency(now - block.info.source_time);
    } else {
      inbox().note_latency(now - block.info.source_time);
    }
    if (taking_ == Taking::Own) return callback_.run(callback_.context, block, *reader_);
    struct Drop {
      Block& block;
      ~Drop() { drop_reference(block); }
    } const drop{block};
    callback_.run(callback_.context, block, *reader_);
  }
  void set_active(bool active) override { reader_->set_enabled(active); }
  void report(CallbackReport& row) const override {
    const DurationHistogram* const latency = reader_->latency();
    fill(row, stats_, latency != nullptr ? *latency : stats_.latency);
  }

  const Taking taking_;
  const bool is_reentrant_;
  const MessageCallback callback_;
  std::unique_ptr<Reader> reader_;
  CallbackStats stats_;
  FutexMutex noting_;
};

class StatusPort final : public StatusEventHandle, private StatusListener, private Executable {
 public:
  StatusPort(NodeRuntime& node, PlainCallback callback, std::shared_ptr<CallbackGroup> group)
      : Executable(*group), node_(node), member_of_(std::move(group)), callback_(callback) {
    describe_as("status event", "");
  }
  ~StatusPort() override { node_.executor().forget(*this); }
  StatusListener& listener() override { return *this; }

 private:
  void on_status() noexcept override { on_ready(); }
  void execute(MonotonicTime) override { callback_.run(callback_.context); }

  NodeRuntime& node_;
  const std::shared_ptr<CallbackGroup> member_of_;
  const PlainCallback callback_;
};

class TimerPort final : public TimerHandle, private PortBase, private TimerBase {
 public:
  TimerPort(NodeRuntime& node, Duration period, PlainCallback callback, const NodeRuntime::GroupPointer& group)
      : PortBase(node, group, "timer", fmt::format("{:g} ms", to_milliseconds(period))),
        TimerBase(*member_of_, period),
        callback_(callback) {
    keep_stats_in(stats_);
    describe_as(PortBase::kind_, name_.c_str());
    node_.enroll(*this);
    node_.executor().add_timer(*this);
  }
  ~TimerPort() override {
    node_.leave(*this);
    cancel();
    node_.executor().forget(*this);
  }
  void cancel() override { node_.executor().cancel_timer(*this); }
  void reset() override { node_.executor().add_timer(*this); }
  bool is_canceled() const override { return !node_.executor().is_armed(*this); }

 private:
  void execute(MonotonicTime) override {
    // It may have been gated or canceled while it waited in the queue.
    if (!node_.active().load(std::memory_order_relaxed) || is_canceled()) return;
    callback_.run(callback_.context);
  }
  void set_active(bool active) override { node_.executor().set_timer_open(*this, active); }
  void report(CallbackReport& row) const override {
    fill(row, stats_, stats_.latency);
    row.skipped = node_.executor().skipped(*this);
  }

  const PlainCallback callback_;
  CallbackStats stats_;
};

// A timer of /clock: the clock makes it ready, the executor runs it.
class SimTimerPort final : public TimerHandle, private PortBase, private Executable {
 public:
  SimTimerPort(NodeRuntime& node, SimClock& clock, Duration period, PlainCallback callback,
               const NodeRuntime::GroupPointer& group)
      : PortBase(node, group, "timer", fmt::format("{:g} ms of /clock", to_milliseconds(period))),
        Executable(*member_of_),
        clock_(clock),
        ticks_(period, *this),
        callback_(callback) {
    keep_stats_in(stats_);
    describe_as(PortBase::kind_, name_.c_str());
    node_.enroll(*this);
    clock_.add(ticks_);
  }
  ~SimTimerPort() override {
    node_.leave(*this);
    clock_.remove(ticks_);
    node_.executor().forget(*this);
  }
  void cancel() override { clock_.remove(ticks_); }
  void reset() override { clock_.add(ticks_); }
  bool is_canceled() const override { return !clock_.has(ticks_); }

 private:
  void execute(MonotonicTime) override {
    // It may have been gated or canceled while it waited in the queue.
    if (!node_.active().load(std::memory_order_relaxed) || is_canceled()) return;
    callback_.run(callback_.context);
  }
  void set_active(bool) override {}  // a tick behind a closed gate does nothing, and the timer keeps its phase
  void report(CallbackReport& row) const override {
    fill(row, stats_, stats_.latency);
    row.skipped = clock_.skipped(ticks_);
  }

  SimClock& clock_;
  SimTicks ticks_;
  const PlainCallback callback_;
  CallbackStats stats_;
};

class ServicePort final : public ServiceHandle, private PortBase {
 public:
  ServicePort(NodeRuntime& node, std::string name, const msgs::MessageType& request, const msgs::MessageType& response,
              ServiceCallback callback, const NodeRuntime::GroupPointer& group)
      : PortBase(node, group, "service", std::move(name)),
        port_(*member_of_, request, response, callback, node.active(), node.commons().clock, node.is_measured()) {
    port_.describe_as(kind_, name_.c_str());
    node_.enroll(*this);  // first, so that a change of the gate meanwhile is reported
    node_.commons().services.add(name_, node_.identity().fully_qualified(), port_);
    node_.enroll(name_, port_);
  }
  ~ServicePort() override {
    node_.leave(port_);
    node_.leave(*this);
    node_.commons().services.remove(name_, port_);
    node_.executor().forget(port_);
    port_.refuse_all();
  }
  bool send_response(std::int64_t call, void* response) override { return port_.send_response(call, response); }

 private:
  // The port checks the gate itself.
  void set_active(bool) override { node_.commons().services.note_gate(name_, port_); }
  void report(CallbackReport& row) const override {
    static const CallbackStats nothing;
    const CallbackStats& stats = port_.stats() != nullptr ? *port_.stats() : nothing;
    fill(row, stats, stats.latency);
  }
  bool describe(ServiceReport& row) const override {
    row = {name_, service_type_of(port_.request_type()), node_.identity().fully_qualified(), true, port_.is_open()};
    return true;
  }
  ServerPort port_;
};

class ClientEnd final : public ClientHandle, private PortBase {
 public:
  ClientEnd(NodeRuntime& node, std::string name, const msgs::MessageType& request, const msgs::MessageType& response,
            ResponseCallback callback, const NodeRuntime::GroupPointer& group)
      : PortBase(node, group, "client", std::move(name)),
        request_(request),
        port_(*member_of_, callback, node.commons().clock) {
    port_.describe_as(kind_, name_.c_str());
    node_.enroll(*this);
    id_ =
        node_.commons().services.add_client({0, false, name_, node_.identity().fully_qualified(), &request, &response});
  }
  ~ClientEnd() override {
    node_.commons().services.remove_client(id_);
    node_.leave(*this);
    port_.detach();
    node_.executor().forget(port_);
  }
  std::int64_t send(void* request) override {
    Call call{{port_.handle(), next_}, AnyMessage{request_}};
    request_.move_assign(call.request.get(), request);
    if (!node_.commons().services.send(name_, request_, std::move(call), id_)) return 0;
    return next_++;
  }
  bool service_is_ready() const override { return node_.commons().services.is_ready(name_, request_, id_); }
  std::string why_not_wait() const override { return node_.executor().why_not_wait_for(*member_of_); }

 private:
  void set_active(bool) override {}
  void report(CallbackReport& row) const override { fill(row, port_.stats(), port_.stats().latency); }
  bool describe(ServiceReport& row) const override {
    row = {name_, service_type_of(request_), node_.identity().fully_qualified(), false, true};
    return true;
  }
  const msgs::MessageType& request_;
  ClientPort port_;
  std::uint64_t id_ = 0;
  std::int64_t next_ = 1;
};

// Runs once, alone in its node. Shared with the waiting thread: either may be the last to need it.
class Task final : public Executable {
 public:
  static constexpr std::uint32_t kWaiting = 0, kEnded = 1, kRefused = 2, kGivenUp = 3;
  Task(CallbackGroup& group, const char* name, std::function<void()> what)
      : Executable(group, Kind::Transition), what_(std::move(what)) {
    describe_as("transition", name);
  }
  void execute(MonotonicTime) override {
    // Abandoned before it began: its requester already has a failure, so it must not run later.
    if (state_.load(std::memory_order_acquire) == kWaiting) what_();
    if (end(kEnded)) return;
    group().executor().forget(*this);
    delete this;
  }
  void discard() noexcept override {
    if (!end(kRefused)) delete this;
  }
  /// kGivenUp: the task deletes itself when it returns or is discarded; otherwise the caller owns it.
  [[nodiscard]] std::uint32_t wait(const Clock& clock, const Deadline& deadline) {
    for (;;) {
      std::uint32_t state = state_.load(std::memory_order_acquire);
      if (state != kWaiting) return state;
      const MonotonicTime now = clock.now(), end = deadline.now();
      if (now >= end && state_.compare_exchange_strong(state, kGivenUp, std::memory_order_acq_rel)) return kGivenUp;
      deadline.note_waiting();
      futex_wait_until(clock, state_, kWaiting, end);
    }
  }

 private:
  // Returns false if it was abandoned meanwhile.
  bool end(std::uint32_t state) {
    std::uint32_t expected = kWaiting;
    if (!state_.compare_exchange_strong(expected, state, std::memory_order_acq_rel)) return false;
    futex_wake(state_, 1);
    return true;
  }
  const std::function<void()> what_;
  std::atomic<std::uint32_t> state_{kWaiting};  // futex
};

// Like Task, but without a waiting thread: it deletes itself, and the supervisor checks that it returns.
class DetachedTask final : public Executable {
 public:
  DetachedTask(CallbackGroup& group, const char* name, const Patience& patience, std::function<void()> what)
      : Executable(group, Kind::Transition), patience_(patience), what_(std::move(what)) {
    describe_as("transition", name);
  }
  void execute(MonotonicTime) override {
    what_();
    group().executor().forget(*this);
    delete this;
  }
  void discard() noexcept override { delete this; }
  Duration time_limit() const noexcept override { return patience_.limit(); }

 private:
  const Patience& patience_;
  const std::function<void()> what_;
};

}  // namespace

NodeRuntime::NodeRuntime(Commons& commons, NodeIdentity identity, Executor& executor, OnFault on_fault, bool measured)
    : commons_(commons),
      identity_(std::move(identity)),
      measured_(measured),
      on_fault_(on_fault),
      groups_(executor, identity_.fully_qualified(), std::move(on_fault)),
      own_group_(std::make_shared<CallbackGroup>(groups_)),
      safe_stop_(groups_.name()) {}

NodeRuntime::~NodeRuntime() = default;

std::unique_ptr<Writer> NodeRuntime::create_writer(const EndpointSpec& spec) {
  EndpointSpec gated = spec;
  gated.gate = &active_;
  gated.on_fault = [this](std::string code, std::string text) { report_fault(std::move(code), std::move(text)); };
  return commons_.broker.create_writer(gated);
}

std::unique_ptr<SubscriptionHandle> NodeRuntime::create_subscription(const EndpointSpec& spec, Taking taking,
                                                                     MessageCallback callback,
                                                                     const GroupPointer& group) {
  return std::make_unique<SubscriptionPort>(*this, spec, taking, callback, group);
}

std::unique_ptr<StatusEventHandle> NodeRuntime::create_status_event(PlainCallback callback, const GroupPointer& group) {
  return std::make_unique<StatusPort>(*this, callback, group_of(group, "status event"));
}

std::unique_ptr<TimerHandle> NodeRuntime::create_timer(SimClock* clock, Duration period, PlainCallback callback,
                                                       const GroupPointer& group) {
  if (clock != nullptr) return std::make_unique<SimTimerPort>(*this, *clock, period, callback, group);
  return std::make_unique<TimerPort>(*this, period, callback, group);
}

std::unique_ptr<ServiceHandle> NodeRuntime::create_service(const std::string& name, const msgs::MessageType& request,
                                                           const msgs::MessageType& response, ServiceCallback callback,
                                                           const GroupPointer& group) {
  return std::make_unique<ServicePort>(*this, name, request, response, callback, group);
}

std::unique_ptr<ClientHandle> NodeRuntime::create_client(const std::string& name, const msgs::MessageType& request,
                                                         const msgs::MessageType& response, ResponseCallback callback,
                                                         const GroupPointer& group) {
  return std::make_unique<ClientEnd>(*this, name, request, response, callback, group);
}

NodeRuntime::GroupPointer NodeRuntime::create_callback_group(CallbackGroupType type) {
  return std::make_shared<CallbackGroup>(groups_, type);
}

std::shared_ptr<CallbackGroup> NodeRuntime::group_of(const GroupPointer& wanted, const char* what) const {
  if (!wanted) return own_group_;
  auto group = std::dynamic_pointer_cast<CallbackGroup>(wanted);
  if (!group || &group->node() != &groups_) {
    throw std::runtime_error(
        fmt::format("node {}: cannot create {}, group not in node: it was made by {}; use one of this "
                    "node's own create_callback_group()",
                    groups_.name(), what, group ? group->node().name() : "another container"));
  }
  return group;
}

DurationHistogram& NodeRuntime::create_histogram(const std::string& name) {
  const LockGuard lock(mutex_);
  for (auto& entry : histograms_) {
    if (entry.name == name) return entry.histogram;
  }
  auto& entry = histograms_.emplace_back();
  entry.name = name;
  return entry.histogram;
}

void NodeRuntime::report_histograms(std::vector<HistogramReport>& out, std::size_t& used) const {
  const LockGuard lock(mutex_);
  for (const auto& entry : histograms_) {
    if (used == out.size()) out.emplace_back();
    HistogramReport& row = out[used++];
    row.node = identity_.name;
    row.name = entry.name;
    row.count = entry.histogram.count();
    row.p50 = entry.histogram.quantile(0.5);
    row.p99 = entry.histogram.quantile(0.99);
    row.max = entry.histogram.max();
  }
}

// The running callback, if any; otherwise the thread's name, which a component gives to its own threads.
std::string NodeRuntime::who_runs_here() const {
  const Executor::RunsHere runs = Executor::runs_here();
  if (runs.node == groups_.name())
    return *runs.name == '\0' ? std::string{runs.what} : fmt::format("{} {}", runs.what, runs.name);
  std::array<char, 17> thread{};
  ::pthread_getname_np(::pthread_self(), thread.data(), thread.size());
  return fmt::format("thread {}", thread.data());
}

void NodeRuntime::report_fault(std::string code, std::string text) {
  on_fault_(std::move(code), std::move(text), who_runs_here());
}

void NodeRuntime::open_fault(const std::string& code, const std::string& text) {
  if (open_faults_.open) open_faults_.open(code, text, who_runs_here());
}

void NodeRuntime::close_fault(const std::string& code) {
  if (open_faults_.close) open_faults_.close(code);
}

void NodeRuntime::set_active(bool active) {
  if (active) safe_stop_.note_activation();
  const LockGuard lock(mutex_);
  active_.store(active, std::memory_order_release);
  for (Port* port : ports_) port->set_active(active);
}

void NodeRuntime::enroll(Port& port) {
  const LockGuard lock(mutex_);
  ports_.push_back(&port);
  if (!active_.load(std::memory_order_relaxed)) port.set_active(false);
}
void NodeRuntime::leave(Port& port) {
  const LockGuard lock(mutex_);
  std::erase(ports_, &port);
}

void NodeRuntime::report_callbacks(std::vector<CallbackReport>& out, std::size_t& used) const {
  const LockGuard lock(mutex_);
  for (const Port* port : ports_) {
    if (used == out.size()) out.emplace_back();
    port->report(out[used++]);
  }
}

void NodeRuntime::report_services(std::vector<ServiceReport>& out) const {
  const LockGuard lock(mutex_);
  for (const Port* port : ports_) {
    ServiceReport row;
    if (port->describe(row)) out.push_back(std::move(row));
  }
}

void NodeRuntime::enroll(const std::string& name, ServerPort& server) {
  const LockGuard lock(mutex_);
  servers_.emplace_back(name, &server);
}
void NodeRuntime::leave(ServerPort& server) {
  const LockGuard lock(mutex_);
  std::erase_if(servers_, [&](const auto& entry) { return entry.second == &server; });
}

void NodeRuntime::withdraw() {
  set_active(false);
  commons_.frames.withdraw(identity_.fully_qualified());
  withdraw_services();
}

void NodeRuntime::withdraw_services() {
  set_active(false);
  const LockGuard lock(mutex_);
  for (const auto& [name, server] : servers_) {
    commons_.services.remove(name, *server);
    server->refuse_all();
  }
}

void NodeRuntime::post(const char* name, const Patience& patience, std::function<void()> what) {
  auto* const task = new DetachedTask(*own_group_, name, patience, std::move(what));
  if (!executor().post(*task)) delete task;
}

bool NodeRuntime::run_and_wait(const char* name, std::function<void()> what, const Deadline& deadline) {
  auto* const task = new Task(*own_group_, name, std::move(what));
  const bool is_posted = executor().post(*task);
  executor().run_ready();  // of a caller's executor no other thread would run it
  const std::uint32_t state = is_posted ? task->wait(commons_.clock, deadline) : Task::kRefused;
  if (state == Task::kGivenUp) return false;
  executor().forget(*task);
  delete task;
  return state == Task::kEnded;
}

}  // namespace nacelle::runtime
