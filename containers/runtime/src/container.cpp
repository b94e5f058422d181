// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/container.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "container_impl.hpp"
#include "nacelle/base/name_fault.hpp"

namespace nacelle::runtime {

double StreamReport::hz() const {
  const double span_s = to_seconds(last - first);
  return published < 2 || span_s <= 0 ? 0.0 : static_cast<double>(published - 1) / span_s;
}

namespace {

const char* callback_of(Transition transition) {
  switch (transition) {
    case Transition::Configure: return "on_configure";
    case Transition::Cleanup: return "on_cleanup";
    case Transition::Activate: return "on_activate";
    case Transition::Deactivate: return "on_deactivate";
    case Transition::Shutdown: return "on_shutdown";
  }
  return "?";
}

// A transition that the state machine refuses runs no callback, so it is not a fault of the component.
bool is_allowed(Transition transition, StateId from) {
  switch (transition) {
    case Transition::Configure: return from == StateId::Unconfigured;
    case Transition::Cleanup:
    case Transition::Activate: return from == StateId::Inactive;
    case Transition::Deactivate: return from == StateId::Active;
    case Transition::Shutdown: return from != StateId::Finalized;
  }
  return false;
}

}  // namespace

Executor& Container::Impl::executor_for(Record& record, const LoadRequest& request) {
  if (request.thread.own && !options.run_by_caller) {
    record.own_executor =
        std::make_unique<Executor>(request.name.empty() ? "own" : request.name, commons.clock, request.thread);
    supervisor.add(*record.own_executor);
    return *record.own_executor;
  }
  auto shared = shared_executor.lock();
  if (!*shared) {
    *shared = std::make_unique<Executor>("executor", commons.clock, ThreadPolicy{},
                                         options.run_by_caller ? Running::ByCaller : Running::ByThreads);
    if (!options.run_by_caller) supervisor.add(**shared);
  }
  return **shared;
}

ComponentInfo Container::Impl::info_of(const Record& record) {
  ComponentInfo info;
  info.id = record.id;
  info.node = record.runtime->identity().fully_qualified();
  info.plugin = record.plugin;
  info.library = record.file;
  info.managed = record.managed != nullptr;
  info.state = record.managed != nullptr ? record.managed->get_current_state().state() : StateId::Unknown;
  info.fault = *record.fault.lock();
  {
    auto open = record.open_faults.lock();
    for (const auto& fault : *open) info.open_faults.push_back(fault.reason);
  }
  info.actuator = record.is_actuator();
  auto others = record.others.lock();
  for (const auto& other : *others) info.other_nodes.push_back(other->runtime->identity().fully_qualified());
  return info;
}

std::shared_ptr<Record> Container::Impl::record(std::uint64_t id) const {
  const LockGuard lock(mutex);
  const auto found = records.find(id);
  return found == records.end() ? nullptr : found->second;
}

// All under one lock: a component that is listed is not destroyed, and unload() takes the runtime of one that is not.
Container::Impl::Asked Container::Impl::ask_for(std::uint64_t id) const {
  const LockGuard lock(mutex);
  const auto found = records.find(id);
  if (found == records.end()) return {};
  const Record& record = *found->second;
  const StateId state = record.managed != nullptr ? record.managed->get_current_state().state() : StateId::Unknown;
  std::string why_not_wait;
  record.for_each_node([&](NodeRuntime& node) {
    if (why_not_wait.empty()) why_not_wait = node.executor().why_not_wait_for(node.groups());
  });
  return {found->second, record.runtime->identity().fully_qualified(), state, std::move(why_not_wait)};
}

Container::Container(ContainerOptions options, const Clock& clock)
    : impl_(std::make_unique<Impl>(*this, std::move(options), clock)) {}

Container::~Container() {
  impl_->services.reset();  // from here on there are no load requests
  for (;;) {
    std::uint64_t last = 0;
    {
      const LockGuard lock(impl_->mutex);
      if (!impl_->records.empty()) last = impl_->records.rbegin()->first;
      if (!impl_->foreign.empty()) last = std::max(last, impl_->foreign.rbegin()->first);
    }
    if (last == 0) break;
    static_cast<void>(unload(last));
  }
  impl_->node_services.reset();
  impl_->sweep();
  // A thread that hangs in a component cannot be joined, and the memory that it uses must stay valid until the process
  // ends.
  if (const std::size_t hanging = abandoned(); hanging != 0) {
    impl_->log.error("{} component(s) hang; their threads end with the process", hanging);
    impl_->supervisor.stop();
    on_fault({});
    on_state({});
    on_change({});
    static_cast<void>(impl_.release());
    return;
  }
  if (auto shared = impl_->shared_executor.lock(); *shared) impl_->supervisor.remove(**shared);
}

const ContainerOptions& Container::options() const { return impl_->options; }
const Clock& Container::clock() const { return impl_->commons.clock; }
Transport& Container::transport() { return impl_->commons.broker; }
Graph& Container::graph() { return impl_->commons.broker; }
ServiceHub& Container::service_graph() { return impl_->commons.services; }

std::string Container::stalled() {
  if (impl_->supervisor.has_stalled()) return "the supervisor has made no progress";
  // Each of them is looked at, so that the next call compares with this one.
  std::string stalled;
  const auto look = [&](Executor& executor) {
    if (executor.has_stalled()) stalled = "executor '" + executor.name() + "' has made no progress";
  };
  if (auto shared = impl_->shared_executor.lock(); *shared) look(**shared);
  if (impl_->node_services) look(impl_->node_services->executor());
  const LockGuard lock(impl_->mutex);
  for (const auto& [id, record] : impl_->records) {
    if (record->own_executor) look(*record->own_executor);
  }
  return stalled;
}

MonotonicTime Container::step() {
  Executor* const executor = impl_->shared_executor.lock()->get();
  for (;;) {
    if (executor != nullptr) executor->run_ready();
    // It may tell status listeners, whose callbacks are then ready.
    const MonotonicTime next = impl_->commons.broker.watch(impl_->commons.clock.now());
    if (executor == nullptr) return next;
    if (executor->is_idle()) return std::min(next, executor->next_timer());
  }
}

void Container::call_while_waiting(std::function<void()> hook) { impl_->patience.call_while_waiting(std::move(hook)); }
void Container::note_waiting() const { impl_->patience.note_waiting(); }

std::vector<ComponentInfo> Container::list() const {
  const LockGuard lock(impl_->mutex);
  std::vector<ComponentInfo> all;
  for (const auto& [id, record] : impl_->records) all.push_back(Impl::info_of(*record));
  for (const auto& [id, component] : impl_->foreign) {
    all.push_back(component->info());
    all.back().id = id;
  }
  std::ranges::sort(all, {}, &ComponentInfo::id);
  return all;
}

Result<ComponentInfo, Problem> Container::find(const std::string& name_or_id) const {
  std::vector<ComponentInfo> hits;
  std::vector<std::string> names;
  for (auto& info : list()) {
    names.push_back(info.node);
    const std::string last = info.node.substr(info.node.rfind('/') + 1);
    const bool owns = std::ranges::find(info.other_nodes, name_or_id) != info.other_nodes.end();
    if (info.node == name_or_id || last == name_or_id || std::to_string(info.id) == name_or_id || owns)
      hits.push_back(std::move(info));
  }
  if (hits.size() == 1) return std::move(hits.front());
  if (hits.empty())
    return err(Problem{"component '" + name_or_id + "'", "is not loaded", suggestion(name_or_id, names),
                       NameFault::Unknown, name_or_id});
  std::vector<std::string> choices;
  choices.reserve(hits.size());
  for (const auto& hit : hits) choices.push_back(hit.node);
  return err(Problem{"component '" + name_or_id + "'", "could be any of " + join(choices),
                     "give the full name or the id", NameFault::Ambiguous, name_or_id});
}

TransitionOutcome Container::trigger(std::uint64_t id, Transition transition) {
  if (const auto other = impl_->foreign_component(id)) return other->trigger(transition);
  const auto asked = impl_->ask_for(id);
  const auto& record = asked.record;
  if (!record) return {false, StateId::Unknown, "component " + std::to_string(id) + " is not loaded"};
  if (!asked.why_not_wait.empty()) return {false, asked.state, "would wait for itself: " + asked.why_not_wait};
  const LockGuard alone(record->one_at_a_time);
  // In this order: sweep() destroys the node of one that was given up, without its lock.
  if (record->given_up || record->node == nullptr) return {false, StateId::Unknown, "it was unloaded meanwhile"};
  if (record->managed == nullptr) return {false, StateId::Unknown, asked.node + " is a plain node without a lifecycle"};
  if (record->hung) return {false, StateId::Finalized, "it hangs: " + record->fault.lock()->text};
  // Shared with the task: if the component hangs, the task outlives this call.
  struct Run {
    TransitionOutcome outcome;
    std::atomic<bool> began{false};
  };
  const auto run = std::make_shared<Run>();
  const MonotonicTime began = impl_->commons.clock.now();
  const Deadline deadline = impl_->deadline();
  const bool was_allowed = is_allowed(transition, record->managed->get_current_state().state());
  const bool ended = record->runtime->run_and_wait(
      callback_of(transition),
      [impl = impl_.get(), record, transition, run, was_allowed] {
        run->began = true;
        // A configure or activate clears the old reason; faults from here on count, also on other threads.
        const bool up = transition == Transition::Configure || transition == Transition::Activate;
        if (up && was_allowed) *record->fault.lock() = {};
        const StateWatch watch = impl->watch_states(*record);
        run->outcome = record->managed->trigger(transition);
      },
      deadline);
  if (ended) {
    if (!run->outcome.success && was_allowed) impl_->note_failed_transition(*record, transition, run->outcome);
    static_cast<void>(impl_->commons.broker.watch(impl_->commons.clock.now()));  // on_configure may have made endpoints
    impl_->note_change();
    return run->outcome;
  }
  TransitionOutcome late{
      false, record->managed->get_current_state().state(),
      fmt::format("{} has not returned within {:.0f} s", callback_of(transition), to_seconds(deadline.now() - began))};
  if (run->began &&
      impl_->keep_reason(*record, "HUNG", late.reason, std::string{"transition "} + callback_of(transition))) {
    impl_->give_up_on(*record);
  }
  return late;
}

void Container::give_up_transitions_after(Duration limit) {
  if (!impl_->patience.set(limit)) return;
  std::vector<std::shared_ptr<ForeignComponent>> others;
  {
    const LockGuard lock(impl_->mutex);
    for (const auto& [id, component] : impl_->foreign) others.push_back(component);
  }
  for (const auto& component : others) component->give_up_transitions_after(limit);
}

std::string Container::node() const { return impl_->services->node(); }
void Container::compose_through(CompositionHost* host) { impl_->services->compose_through(host); }

std::unique_ptr<ServiceHandle> Container::offer_service(const std::string& name, const msgs::MessageType& request,
                                                        const msgs::MessageType& response, ServiceCallback callback) {
  return impl_->services->offer(name, request, response, callback);
}

bool Container::service_is_ready(const std::string& name) const { return impl_->commons.services.is_ready(name); }

std::vector<ClashReport> Container::clashes() const { return impl_->commons.broker.clashes(); }

std::vector<Problem> Container::frame_conflicts() const { return impl_->commons.frames.conflicts(); }

std::vector<ClaimedFrame> Container::frames() const { return impl_->commons.frames.list(); }

WiringReport Container::wiring(const std::string& topic, Duration age) const {
  return impl_->commons.broker.wiring(topic, age);
}

std::vector<std::string> Container::topics_of(const std::string& node) const {
  return impl_->commons.broker.topics_of(node);
}

void Container::report_streams(std::vector<StreamReport>& out) const { impl_->commons.broker.report(out); }

void Container::report_readers(std::vector<ReaderReport>& out) const { impl_->commons.broker.report(out); }

void Container::report_histograms(std::vector<HistogramReport>& out) const {
  const LockGuard lock(impl_->mutex);
  std::size_t used = 0;
  for (const auto& [id, record] : impl_->records) {
    record->for_each_node([&](const NodeRuntime& node) { node.report_histograms(out, used); });
  }
  out.resize(used);
}

void Container::report_callbacks(std::vector<CallbackReport>& out) const {
  const LockGuard lock(impl_->mutex);
  std::size_t used = 0;
  for (const auto& [id, record] : impl_->records) {
    record->for_each_node([&](const NodeRuntime& node) { node.report_callbacks(out, used); });
  }
  out.resize(used);
}

void Container::report_threads(std::vector<ThreadReport>& out) const {
  std::size_t used = 0;
  if (auto shared = impl_->shared_executor.lock(); *shared) (*shared)->report_threads(out, used);
  const LockGuard lock(impl_->mutex);
  for (const auto& [id, record] : impl_->records) {
    if (record->own_executor) record->own_executor->report_threads(out, used);
  }
  out.resize(used);
}

void Container::report_loads(std::vector<LoadReport>& out) const {
  const LockGuard lock(impl_->mutex);
  std::size_t used = 0;
  for (const auto& [id, record] : impl_->records) {
    record->for_each_node([&](const NodeRuntime& node) {
      if (used == out.size()) out.emplace_back();
      node.report_load(out[used++]);
    });
  }
  out.resize(used);
}

const msgs::MessageType* Container::topic_type(const std::string& topic) const {
  return impl_->commons.broker.topic_type(topic);
}

std::shared_ptr<void> Container::shared_object(const std::string& name) const {
  auto objects = impl_->commons.shared_objects.lock();
  const auto found = objects->find(name);
  return found == objects->end() ? nullptr : found->second;
}

void Container::write_safe_stops() const { impl_->write_safe_stops(); }

Result<std::vector<ParameterReport>, Problem> Container::parameters_of(std::uint64_t id) const {
  return impl_->parameters_of(id);
}

std::optional<LoadRequest> Container::request_of(std::uint64_t id) const {
  if (const auto record = impl_->record(id)) return *record->request.lock();
  if (const auto foreign = impl_->foreign_component(id)) return foreign->request();
  return std::nullopt;
}

}  // namespace nacelle::runtime
