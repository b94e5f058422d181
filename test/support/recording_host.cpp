// SPDX-License-Identifier: Apache-2.0
#include "recording_host.hpp"

#include <algorithm>
#include <deque>
#include <list>
#include <set>

namespace nacelle::test {

namespace {

class Port;

struct Log {
  const msgs::MessageType* type = nullptr;
  std::unique_ptr<Reader> reader;
  std::vector<Block*> blocks;
};

}  // namespace

struct RecordingContext::State {
  explicit State(const Clock& c) : clock(c), transport(c) {}
  std::map<std::string, std::vector<std::pair<std::string, Announced>>> announced;
  ~State() {
    for (auto& [name, log] : logs) {
      for (Block* block : log.blocks) drop_reference(*block);
    }
  }
  struct Timer {
    Duration period;
    PlainCallback callback;
    MonotonicTime due;
    bool canceled = false;
    const bool* active;
  };
  struct Server {
    ServiceCallback callback;
    const msgs::MessageType* response;
    const bool* active;
  };
  struct Wakeup final : ReadyListener {
    State* state = nullptr;
    void on_ready() noexcept override {
      const std::lock_guard lock(state->mutex);
      ++state->arrivals;
      state->arrived.notify_all();
    }
  };

  void record(const EndpointSpec& spec) {
    if (logs.count(spec.topic) != 0 || unread.count(spec.topic) != 0) return;
    EndpointSpec all = spec;
    all.gate = nullptr;
    all.node = "/recorder";
    all.qos = QoS(KeepAll{}).max_samples(1000000).best_effort();
    if (spec.qos.resolved().durability() == Durability::TransientLocal) all.qos.transient_local();
    logs[spec.topic].type = spec.type;
    logs[spec.topic].reader = transport.create_reader(all, Taking::Share, &wakeup);
  }
  void drain(Log& log) {
    while (Block* const block = log.reader->take()) log.blocks.push_back(block);
  }

  const Clock& clock;
  std::mutex mutex;
  std::condition_variable arrived;
  std::uint64_t arrivals = 0;
  Wakeup wakeup;
  FakeTransport transport;
  std::map<std::string, Log> logs;
  std::set<std::string> unread;
  std::list<SubscriptionHandle*> ports;
  std::list<Timer*> timers;
  std::map<std::string, Server> servers;
  std::int64_t last_call = 0, open_call = 0;  // the one that is being made, 0 once it is answered
  const msgs::MessageType* open_type = nullptr;
  void* open_response = nullptr;
  std::map<std::string, std::unique_ptr<Writer>> injectors;
  std::vector<FaultReason> faults, open_faults;
  std::size_t closed_faults = 0;
  std::vector<Claimed> frames;
  std::map<std::string, std::string> frame_owners;
  std::vector<std::uint8_t> safe_stop;
  std::vector<int> safe_stop_descriptors;
  std::map<std::string, DurationHistogram> histograms;
  std::map<std::string, std::shared_ptr<void>> shared_objects;
};

class RecordingHost final : public NodeHost {
 public:
  RecordingHost(RecordingContext& context, NodeIdentity identity)
      : state_(*context.state_), identity_(std::move(identity)) {}

  const Clock& clock() const override { return state_.clock; }
  std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override {
    state_.record(spec);
    EndpointSpec gated = spec;
    gated.gate = &gate_;
    return state_.transport.create_writer(gated);
  }
  std::unique_ptr<SubscriptionHandle> create_subscription(const EndpointSpec& spec, Taking taking,
                                                          MessageCallback callback,
                                                          const CallbackGroup::SharedPtr&) override;
  std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, ReadyListener& listener) override {
    return state_.transport.create_reader(spec, Taking::Share, &listener);
  }
  /// Nothing is told: this transport has no graph.
  std::unique_ptr<GraphWatchHandle> watch_graph(GraphListener&) override {
    return std::make_unique<GraphWatchHandle>();
  }
  std::unique_ptr<ServiceWatchHandle> watch_services(ServiceListener&) override {
    return std::make_unique<ServiceWatchHandle>();
  }
  /// Runs at once: there is no executor to leave it to.
  std::unique_ptr<StatusEventHandle> create_status_event(PlainCallback callback,
                                                         const CallbackGroup::SharedPtr&) override {
    struct Handle final : StatusEventHandle, StatusListener {
      explicit Handle(PlainCallback c) : callback(c) {}
      StatusListener& listener() override { return *this; }
      void on_status() noexcept override { callback.run(callback.context); }
      PlainCallback callback;
    };
    return std::make_unique<Handle>(callback);
  }
  std::unique_ptr<TimerHandle> create_timer(TimerClock, Duration period, PlainCallback callback,
                                            const CallbackGroup::SharedPtr&) override;
  CallbackGroup::SharedPtr create_callback_group(CallbackGroupType type) override {
    struct Group final : CallbackGroup {
      explicit Group(CallbackGroupType t) : CallbackGroup(t) {}
    };
    return std::make_shared<Group>(type);  // one thread: it changes nothing
  }
  std::unique_ptr<ServiceHandle> create_service(const std::string& name, const msgs::MessageType&,
                                                const msgs::MessageType& response, ServiceCallback callback,
                                                const CallbackGroup::SharedPtr&) override {
    struct Handle final : ServiceHandle {
      Handle(RecordingContext::State& s, std::string n) : state(s), name(std::move(n)) {}
      ~Handle() override { state.servers.erase(name); }
      bool send_response(std::int64_t call, void* response) override {
        if (call != state.open_call) return false;
        state.open_type->move_assign(state.open_response, response);
        state.open_call = 0;
        return true;
      }
      RecordingContext::State& state;
      std::string name;
    };
    state_.servers[name] = {callback, &response, &active_};
    return std::make_unique<Handle>(state_, name);
  }
  std::unique_ptr<ClientHandle> create_client(const std::string&, const msgs::MessageType&, const msgs::MessageType&,
                                              ResponseCallback, const CallbackGroup::SharedPtr&) override {
    struct Handle final : ClientHandle {
      std::int64_t send(void*) override { return 0; }
      bool service_is_ready() const override { return false; }
    };
    return std::make_unique<Handle>();
  }
  std::unique_ptr<FrameClaim> claim_frame(const std::string& parent, const std::string& child, FrameClaimKind kind,
                                          const Place&) override {
    struct Claim final : FrameClaim {
      Claim(RecordingContext::State& s, std::string c) : state(s), child(std::move(c)) {}
      bool is_owner() const override { return !withdrawn && state.frame_owners.count(child) == 0; }
      std::string owner() const override {
        const auto it = state.frame_owners.find(child);
        return it == state.frame_owners.end() ? "" : it->second;
      }
      void withdraw() override { withdrawn = true; }
      RecordingContext::State& state;
      std::string child;
      bool withdrawn = false;
    };
    state_.frames.push_back({parent, child, kind});
    return std::make_unique<Claim>(state_, child);
  }
  std::shared_ptr<void> shared_object(const std::string& name, std::shared_ptr<void> (*make)()) override {
    auto& object = state_.shared_objects[name];
    if (!object) object = make();
    return object;
  }
  DurationHistogram& create_histogram(const std::string& name) override { return state_.histograms[name]; }
  void register_safe_stop(int descriptor, ByteView frame) override {
    state_.safe_stop.assign(frame.begin(), frame.end());
    state_.safe_stop_descriptors.push_back(descriptor);
  }
  void clear_safe_stop() override {
    state_.safe_stop.clear();
    state_.safe_stop_descriptors.clear();
  }
  void report_fault(std::string code, std::string text) override {
    const std::lock_guard lock(state_.mutex);
    state_.faults.push_back({std::move(code), std::move(text)});
    ++state_.arrivals;
    state_.arrived.notify_all();
  }
  void open_fault(std::string code, std::string text) override {
    const std::lock_guard lock(state_.mutex);
    std::erase_if(state_.open_faults, [&](const FaultReason& fault) { return fault.code == code; });
    state_.open_faults.push_back({std::move(code), std::move(text)});
    ++state_.arrivals;
    state_.arrived.notify_all();
  }
  void close_fault(const std::string& code) override {
    const std::lock_guard lock(state_.mutex);
    state_.closed_faults +=
        std::erase_if(state_.open_faults, [&](const FaultReason& fault) { return fault.code == code; });
    ++state_.arrivals;
    state_.arrived.notify_all();
  }
  void set_parameters(ParameterStore& /*parameters*/) override {}
  void set_active(bool active) override {
    active_ = active;
    gate_ = active;
    for (Reader* reader : readers_) reader->set_enabled(active);
  }

  RecordingContext::State& state_;
  const NodeIdentity identity_;
  bool active_ = true;
  std::atomic<bool> gate_{true};
  std::vector<Reader*> readers_;
};

namespace {

class Port final : public SubscriptionHandle {
 public:
  Port(std::unique_ptr<Reader> reader, Taking taking, MessageCallback callback, std::list<SubscriptionHandle*>& ports,
       std::vector<Reader*>& readers)
      : reader_(std::move(reader)), taking_(taking), callback_(callback), ports_(ports), readers_(readers) {
    ports_.push_back(this);
    readers_.push_back(reader_.get());
  }
  ~Port() override {
    ports_.remove(this);
    std::erase(readers_, reader_.get());
  }
  Reader& reader() override { return *reader_; }
  bool run_one() {
    Block* const block = reader_->take();
    if (block == nullptr) return false;
    callback_.run(callback_.context, *block, *reader_);
    if (taking_ == Taking::Share) drop_reference(*block);
    return true;
  }

 private:
  std::unique_ptr<Reader> reader_;
  const Taking taking_;
  const MessageCallback callback_;
  std::list<SubscriptionHandle*>& ports_;
  std::vector<Reader*>& readers_;
};

}  // namespace

std::unique_ptr<SubscriptionHandle> RecordingHost::create_subscription(const EndpointSpec& spec, Taking taking,
                                                                       MessageCallback callback,
                                                                       const CallbackGroup::SharedPtr&) {
  auto reader = state_.transport.create_reader(spec, taking, nullptr);
  {
    const std::lock_guard lock(state_.mutex);
    state_.announced[spec.topic].emplace_back(spec.type->name, spec.announced);
  }
  if (!active_) reader->set_enabled(false);
  return std::make_unique<Port>(std::move(reader), taking, callback, state_.ports, readers_);
}

std::unique_ptr<TimerHandle> RecordingHost::create_timer(TimerClock, Duration period, PlainCallback callback,
                                                         const CallbackGroup::SharedPtr&) {
  struct Handle final : TimerHandle {
    Handle(RecordingContext::State& s, RecordingContext::State::Timer t) : state(s), timer(t) {
      state.timers.push_back(&timer);
    }
    ~Handle() override { state.timers.remove(&timer); }
    void cancel() override { timer.canceled = true; }
    void reset() override {
      timer.canceled = false;
      timer.due = state.clock.now() + timer.period;
    }
    bool is_canceled() const override { return timer.canceled; }
    RecordingContext::State& state;
    RecordingContext::State::Timer timer;
  };
  return std::make_unique<Handle>(
      state_, RecordingContext::State::Timer{period, callback, state_.clock.now() + period, false, &active_});
}

RecordingContext::RecordingContext() : state_(std::make_unique<State>(manual_)) { state_->wakeup.state = state_.get(); }
RecordingContext::RecordingContext(const Clock& clock) : state_(std::make_unique<State>(clock)) {
  state_->wakeup.state = state_.get();
}
RecordingContext::~RecordingContext() = default;

std::unique_ptr<NodeHost> RecordingContext::create_host(const NodeIdentity& identity) {
  return std::make_unique<RecordingHost>(*this, identity);
}

void RecordingContext::leave_unread(const std::string& topic) { state_->unread.insert(topic); }

std::size_t RecordingContext::forget(const std::string& topic) {
  const auto found = state_->logs.find(topic);
  if (found == state_->logs.end()) return 0;
  state_->drain(found->second);
  for (Block* const block : found->second.blocks) drop_reference(*block);
  const std::size_t count = found->second.blocks.size();
  found->second.blocks.clear();
  return count;
}

void RecordingContext::spin() {
  for (bool any = true; any;) {
    any = false;
    for (SubscriptionHandle* port : std::list<SubscriptionHandle*>(state_->ports))
      any |= static_cast<Port*>(port)->run_one();
  }
}

void RecordingContext::advance(Duration by) {
  const MonotonicTime end = manual_.now() + by;
  while (manual_.now() < end) {
    manual_.advance(std::min<Duration>(1ms, end - manual_.now()));
    static_cast<void>(state_->transport.watch(manual_.now()));
    for (State::Timer* timer : std::list<State::Timer*>(state_->timers)) {
      if (timer->due > manual_.now()) continue;
      timer->due += timer->period;
      if (!timer->canceled && *timer->active) timer->callback.run(timer->callback.context);
    }
    spin();
  }
}

void RecordingContext::inject(const std::string& topic, const msgs::MessageType& type, const void* message) {
  auto& writer = state_->injectors[topic + " " + type.name];
  if (!writer) {
    // Offers the most there is, so that every subscription matches.
    writer = state_->transport.create_writer({topic, &type, QoS(1000).reliable().transient_local(), "/test"});
  }
  Block* const block = writer->borrow();
  type.copy_assign(block->message, message);
  writer->publish(*block);
  spin();
}

void RecordingContext::collect(const std::string& topic, const std::function<void(const void*)>& each) {
  const auto found = state_->logs.find(topic);
  if (found == state_->logs.end()) return;
  state_->drain(found->second);
  for (const Block* block : found->second.blocks) each(block->message);
}

bool RecordingContext::wait_for(const std::string& topic, std::size_t messages, Duration limit) {
  const auto found = state_->logs.find(topic);
  if (found == state_->logs.end()) return false;
  const auto deadline = std::chrono::steady_clock::now() + limit;
  std::unique_lock lock(state_->mutex);
  for (;;) {
    const std::uint64_t seen = state_->arrivals;
    lock.unlock();
    state_->drain(found->second);
    if (found->second.blocks.size() >= messages) return true;
    lock.lock();
    if (!state_->arrived.wait_until(lock, deadline, [&] { return state_->arrivals != seen; })) return false;
  }
}

bool RecordingContext::call(const std::string& service, void* request, void* response) {
  const auto found = state_->servers.find(service);
  if (found == state_->servers.end() || !*found->second.active) return false;
  const std::int64_t call = ++state_->last_call;
  state_->open_call = call;
  state_->open_type = found->second.response;
  state_->open_response = response;
  const bool in_place = found->second.callback.run(found->second.callback.context, call, request, response);
  const bool answered = in_place || state_->open_call == 0;
  state_->open_call = 0;
  return answered;
}

std::vector<std::pair<std::string, Announced>> RecordingContext::announced(const std::string& topic) const {
  const std::lock_guard lock(state_->mutex);
  const auto found = state_->announced.find(topic);
  return found == state_->announced.end() ? decltype(found->second){} : found->second;
}
std::vector<FaultReason> RecordingContext::faults() const {
  const std::lock_guard lock(state_->mutex);
  return state_->faults;
}
std::size_t RecordingContext::closed_faults() const {
  const std::lock_guard lock(state_->mutex);
  return state_->closed_faults;
}
std::vector<FaultReason> RecordingContext::open_faults() const {
  const std::lock_guard lock(state_->mutex);
  return state_->open_faults;
}
void RecordingContext::wait_for_open_faults(std::size_t count) {
  std::unique_lock lock(state_->mutex);
  state_->arrived.wait(lock, [&] { return state_->open_faults.size() == count; });
}
bool RecordingContext::wait_for_open_faults(std::size_t count, Duration limit) {
  std::unique_lock lock(state_->mutex);
  return state_->arrived.wait_for(lock, limit, [&] { return state_->open_faults.size() == count; });
}
std::vector<RecordingContext::Claimed> RecordingContext::frames() const { return state_->frames; }
void RecordingContext::set_frame_owner(const std::string& child, const std::string& other_node) {
  state_->frame_owners[child] = other_node;
}
std::vector<std::uint8_t> RecordingContext::safe_stop() const { return state_->safe_stop; }
std::vector<int> RecordingContext::safe_stop_descriptors() const { return state_->safe_stop_descriptors; }
DurationHistogram& RecordingContext::histogram(const std::string& name) { return state_->histograms[name]; }
std::shared_ptr<void> RecordingContext::shared_object(const std::string& name, std::shared_ptr<void> (*make)()) {
  auto& object = state_->shared_objects[name];
  if (!object) object = make();
  return object;
}

}  // namespace nacelle::test
