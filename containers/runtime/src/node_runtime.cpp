// SPDX-License-Identifier: Apache-2.0
#include "node_runtime.hpp"

#include <unistd.h>

#include <algorithm>

#include "nacelle/base/expect.hpp"

namespace nacelle::runtime {
namespace {

class SubscriptionPort final : public SubscriptionHandle, private Executable {
 public:
  SubscriptionPort(NodeRuntime& node, EndpointSpec spec, Taking taking, MessageCallback callback)
      : Executable(node.group()), node_(node), taking_(taking), callback_(callback) {
    spec.gate = &node.active();
    reader_ = node.commons().broker.create_reader(spec, taking, this);
    node_.enroll(*reader_);
  }
  ~SubscriptionPort() override {
    node_.leave(*reader_);
    group().executor().forget(*this);
  }
  Reader& reader() override { return *reader_; }

 private:
  void execute(MonotonicTime now) override {
    Block* const block = reader_->take();
    if (block == nullptr) return;
    reader_->note_latency(now - block->info.source_time);
    if (taking_ == Taking::Own) {
      callback_.run(callback_.context, *block, *reader_);
      return;
    }
    struct Drop {
      Block* block;
      ~Drop() { drop_reference(*block); }
    } const drop{block};
    callback_.run(callback_.context, *block, *reader_);
  }
  bool wants_again() const override { return reader_->has_waiting(); }

  NodeRuntime& node_;
  const Taking taking_;
  const MessageCallback callback_;
  std::unique_ptr<Reader> reader_;
};

class TimerPort final : public TimerHandle, private TimerBase {
 public:
  TimerPort(NodeRuntime& node, Duration period, PlainCallback callback)
      : TimerBase(node.group(), period), node_(node), callback_(callback) {
    group().executor().add_timer(*this);
  }
  ~TimerPort() override {
    cancel();
    group().executor().forget(*this);
  }
  void cancel() override { group().executor().cancel_timer(*this); }
  void reset() override { group().executor().add_timer(*this); }
  bool is_canceled() const override { return !group().executor().is_armed(*this); }

 private:
  void execute(MonotonicTime) override {
    // It may have been gated or canceled while it waited in the queue.
    if (is_open() && group().executor().is_armed(*this)) callback_.run(callback_.context);
  }
  bool is_open() const override { return node_.active().load(std::memory_order_relaxed); }

  NodeRuntime& node_;
  const PlainCallback callback_;
};

class ServicePort final : public ServiceHandle {
 public:
  ServicePort(NodeRuntime& node, std::string name, const msgs::MessageType& request, const msgs::MessageType& response,
              ServiceCallback callback)
      : node_(node), name_(std::move(name)), port_(node.group(), request, response, callback, node.active()) {
    node_.commons().services.add(name_, port_);
    node_.enroll(name_, port_);
  }
  ~ServicePort() override {
    node_.leave(port_);
    node_.commons().services.remove(name_, port_);
    node_.group().executor().forget(port_);
    port_.refuse_all();
  }

 private:
  NodeRuntime& node_;
  const std::string name_;
  ServerPort port_;
};

class ClientEnd final : public ClientHandle {
 public:
  ClientEnd(NodeRuntime& node, std::string name, const msgs::MessageType& request, ResponseCallback callback)
      : node_(node), name_(std::move(name)), request_(request), port_(node.group(), callback) {}
  ~ClientEnd() override {
    port_.detach();
    node_.group().executor().forget(port_);
  }
  std::int64_t send(void* request) override {
    Call call{{port_.handle(), next_}, AnyMessage{request_}};
    request_.move_assign(call.request.get(), request);
    if (!node_.commons().services.send(name_, request_, std::move(call))) return 0;
    return next_++;
  }
  bool service_is_ready() const override { return node_.commons().services.is_ready(name_, request_); }

 private:
  NodeRuntime& node_;
  const std::string name_;
  const msgs::MessageType& request_;
  ClientPort port_;
  std::int64_t next_ = 1;
};

// Runs once on the component's executor. Shared with the waiting thread: either may be the last to need it.
class Task final : public Executable {
 public:
  enum State : std::uint32_t { kWaiting, kEnded, kDropped, kGivenUp };
  Task(CallbackGroup& group, std::function<void()> what) : Executable(group), what_(std::move(what)) {}
  void execute(MonotonicTime) override {
    // Given up before it began: whoever wanted it has been told that it failed, so it must not happen later.
    if (state_.load(std::memory_order_acquire) == kWaiting) what_();
    std::uint32_t expected = kWaiting;
    if (state_.compare_exchange_strong(expected, kEnded, std::memory_order_acq_rel)) {
      futex_wake(state_, 1);
    } else {
      group().executor().forget(*this);
      delete this;
    }
  }
  bool may_take_long() const override { return true; }
  void on_dropped() noexcept override {
    std::uint32_t expected = kWaiting;
    if (state_.compare_exchange_strong(expected, kDropped, std::memory_order_acq_rel)) {
      futex_wake(state_, 1);
    } else {
      delete this;
    }
  }
  /// kGivenUp: the task ends itself, when it returns or is dropped; else it is the caller's.
  [[nodiscard]] std::uint32_t wait(const Clock& clock, MonotonicTime deadline) {
    for (;;) {
      std::uint32_t state = state_.load(std::memory_order_acquire);
      if (state != kWaiting) return state;
      if (clock.now() >= deadline && state_.compare_exchange_strong(state, kGivenUp, std::memory_order_acq_rel))
        return kGivenUp;
      futex_wait_until(clock, state_, kWaiting, deadline);
    }
  }

 private:
  const std::function<void()> what_;
  std::atomic<std::uint32_t> state_{kWaiting};  // futex
};

// As Task, but nobody waits for it: it ends itself.
class DetachedTask final : public Executable {
 public:
  DetachedTask(CallbackGroup& group, std::function<void()> what) : Executable(group), what_(std::move(what)) {}
  void execute(MonotonicTime) override {
    what_();
    group().executor().forget(*this);
    delete this;
  }
  bool may_take_long() const override { return true; }
  void on_dropped() noexcept override { delete this; }

 private:
  const std::function<void()> what_;
};

}  // namespace

NodeRuntime::NodeRuntime(Commons& commons, NodeIdentity identity, Executor& executor, OnFault on_fault)
    : commons_(commons),
      identity_(std::move(identity)),
      on_fault_(on_fault),
      group_(executor, identity_.fully_qualified(), std::move(on_fault)) {
  executor.hold(group_);
}

NodeRuntime::~NodeRuntime() = default;

std::unique_ptr<Writer> NodeRuntime::create_writer(const EndpointSpec& spec) {
  EndpointSpec gated = spec;
  gated.gate = &active_;
  return commons_.broker.create_writer(gated);
}

std::unique_ptr<SubscriptionHandle> NodeRuntime::create_subscription(const EndpointSpec& spec, Taking taking,
                                                                     MessageCallback callback) {
  return std::make_unique<SubscriptionPort>(*this, spec, taking, callback);
}

std::unique_ptr<TimerHandle> NodeRuntime::create_timer(Duration period, PlainCallback callback) {
  return std::make_unique<TimerPort>(*this, period, callback);
}

std::unique_ptr<ServiceHandle> NodeRuntime::create_service(const std::string& name, const msgs::MessageType& request,
                                                           const msgs::MessageType& response,
                                                           ServiceCallback callback) {
  return std::make_unique<ServicePort>(*this, name, request, response, callback);
}

std::unique_ptr<ClientHandle> NodeRuntime::create_client(const std::string& name, const msgs::MessageType& request,
                                                         const msgs::MessageType&, ResponseCallback callback) {
  return std::make_unique<ClientEnd>(*this, name, request, callback);
}

DurationHistogram& NodeRuntime::create_histogram(const std::string& name) {
  const std::lock_guard lock(mutex_);
  for (auto& entry : histograms_) {
    if (entry.name == name) return entry.histogram;
  }
  auto& entry = histograms_.emplace_back();
  entry.name = name;
  return entry.histogram;
}

void NodeRuntime::report_histograms(std::vector<HistogramReport>& out, std::size_t& used) const {
  const std::lock_guard lock(mutex_);
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

void NodeRuntime::register_safe_stop(int descriptor, ByteView frame) {
  NACELLE_EXPECT(frame.size() <= safe_stop_.frame.size(), "a stop frame fits into 64 bytes");
  safe_stop_.descriptor.store(-1, std::memory_order_release);
  std::ranges::copy(frame, safe_stop_.frame.begin());
  safe_stop_.length = frame.size();
  safe_stop_.descriptor.store(descriptor, std::memory_order_release);
}

void NodeRuntime::clear_safe_stop() { safe_stop_.descriptor.store(-1, std::memory_order_release); }

void NodeRuntime::write_safe_stop() const noexcept {
  const int descriptor = safe_stop_.descriptor.load(std::memory_order_acquire);
  if (descriptor < 0) return;
  // One attempt: the line is non-blocking, and whoever calls this has nobody to tell.
  static_cast<void>(!::write(descriptor, safe_stop_.frame.data(), safe_stop_.length));
}

void NodeRuntime::set_active(bool active) {
  const std::lock_guard lock(mutex_);
  active_.store(active, std::memory_order_release);
  for (Reader* reader : readers_) reader->set_enabled(active);
}

void NodeRuntime::enroll(Reader& reader) {
  const std::lock_guard lock(mutex_);
  readers_.push_back(&reader);
  if (!active_.load(std::memory_order_relaxed)) reader.set_enabled(false);
}
void NodeRuntime::leave(Reader& reader) {
  const std::lock_guard lock(mutex_);
  std::erase(readers_, &reader);
}

void NodeRuntime::enroll(const std::string& name, ServerPort& server) {
  const std::lock_guard lock(mutex_);
  servers_.emplace_back(name, &server);
}
void NodeRuntime::leave(ServerPort& server) {
  const std::lock_guard lock(mutex_);
  std::erase_if(servers_, [&](const auto& entry) { return entry.second == &server; });
}

void NodeRuntime::withdraw() {
  set_active(false);
  commons_.frames.withdraw(identity_.fully_qualified());
  const std::lock_guard lock(mutex_);
  for (const auto& [name, server] : servers_) {
    commons_.services.remove(name, *server);
    server->refuse_all();
  }
}

void NodeRuntime::post(std::function<void()> what) {
  group_.executor().post(*new DetachedTask(group_, std::move(what)));
}

bool NodeRuntime::run_and_wait(std::function<void()> what, MonotonicTime deadline) {
  auto* const task = new Task(group_, std::move(what));
  group_.executor().post(*task);
  const std::uint32_t state = task->wait(commons_.clock, deadline);
  if (state == Task::kGivenUp) return false;
  group_.executor().forget(*task);
  delete task;
  return state == Task::kEnded;
}

}  // namespace nacelle::runtime
