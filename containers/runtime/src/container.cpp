// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/container.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>

#include "nacelle/base/log.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "node_runtime.hpp"
#include "supervisor.hpp"

namespace nacelle::runtime {
namespace {

// What Node sees: the runtime half outlives it by as long as the container needs.
class Host final : public NodeHost {
 public:
  explicit Host(std::shared_ptr<NodeRuntime> node) : node_(std::move(node)) {}
  const Clock& clock() const override { return node_->commons().clock; }
  std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override { return node_->create_writer(spec); }
  std::unique_ptr<SubscriptionHandle> create_subscription(const EndpointSpec& spec, Taking taking,
                                                          MessageCallback callback) override {
    return node_->create_subscription(spec, taking, callback);
  }
  std::unique_ptr<TimerHandle> create_timer(Duration period, PlainCallback callback) override {
    return node_->create_timer(period, callback);
  }
  std::unique_ptr<ServiceHandle> create_service(const std::string& name, const msgs::MessageType& request,
                                                const msgs::MessageType& response, ServiceCallback callback) override {
    return node_->create_service(name, request, response, callback);
  }
  std::unique_ptr<ClientHandle> create_client(const std::string& name, const msgs::MessageType& request,
                                              const msgs::MessageType& response, ResponseCallback callback) override {
    return node_->create_client(name, request, response, callback);
  }
  std::unique_ptr<FrameClaim> claim_frame(const std::string& parent, const std::string& child,
                                          FrameClaimKind kind) override {
    return node_->commons().frames.claim(node_->identity().fully_qualified(), parent, child, kind);
  }
  std::shared_ptr<void> shared_object(const std::string& name, std::shared_ptr<void> (*make)()) override {
    auto& object = (*node_->commons().shared_objects.lock())[name];
    if (!object) object = make();
    return object;
  }
  DurationHistogram& create_histogram(const std::string& name) override { return node_->create_histogram(name); }
  void register_safe_stop(int descriptor, ByteView frame) override { node_->register_safe_stop(descriptor, frame); }
  void clear_safe_stop() override { node_->clear_safe_stop(); }
  void report_fault(std::string code, std::string text) override {
    node_->report_fault(std::move(code), std::move(text));
  }
  void set_active(bool active) override { node_->set_active(active); }

 private:
  const std::shared_ptr<NodeRuntime> node_;
};

// One loaded component. Its members are destroyed from below: first the node, its executor last but one, the image last.
struct Record {
  std::uint64_t id = 0;
  std::string plugin;
  std::unique_ptr<PluginLibrary> library;
  std::unique_ptr<Executor> own_executor;
  const ComponentClass* made_by = nullptr;
  std::shared_ptr<NodeRuntime> runtime;
  Node* node = nullptr;
  LifecycleNode* managed = nullptr;
  std::mutex one_at_a_time;  // transitions and unloading of this component
  Guarded<FaultReason> fault;
  std::atomic<bool> hung{false};

  ~Record() {
    if (node != nullptr) made_by->destroy(node);
    runtime.reset();
    own_executor.reset();
  }
};

struct KeptImage {
  std::string node;
  std::unique_ptr<PluginLibrary> library;
};

// Whom the component constructor that runs on this thread belongs to.
struct Making {
  Record* record = nullptr;
  Executor* executor = nullptr;
};
thread_local Making making;

}  // namespace

double StreamReport::hz() const {
  const double span_s = to_seconds(last - first);
  return published < 2 || span_s <= 0 ? 0.0 : static_cast<double>(published - 1) / span_s;
}

std::string ClashReport::text() const {
  return fmt::format("{}: {} publishes with {} {}, {} asks for {}: it would get nothing; {}", topic, writer_node,
                     policy, offered, reader_node, requested, change);
}

struct Container::Impl {
  Impl(ContainerOptions o, const Clock& clock)
      : options(std::move(o)), commons(clock), supervisor({options.handover_after, options.hang_after}) {}

  const ContainerOptions options;
  const Logger log{"container"};
  Commons commons;
  Supervisor supervisor;
  std::unique_ptr<Executor> shared_executor;  // made with the first component that shares it
  mutable std::mutex mutex;                   // records, kept images, the shared executor
  std::map<std::uint64_t, std::shared_ptr<Record>> records;
  std::vector<std::shared_ptr<Record>> abandoned;  // their callback never returned
  std::vector<KeptImage> kept_images;
  std::uint64_t next_id = 1;
  Guarded<std::function<void(const ComponentInfo&)>> fault_listener;

  Executor& executor_for(Record& record, const LoadRequest& request) {
    if (request.thread.own) {
      record.own_executor =
          std::make_unique<Executor>(request.name.empty() ? "own" : request.name, commons.clock, request.thread);
      supervisor.add(*record.own_executor);
      return *record.own_executor;
    }
    const std::lock_guard lock(mutex);
    if (!shared_executor) {
      shared_executor = std::make_unique<Executor>("executor", commons.clock, ThreadPolicy{});
      supervisor.add(*shared_executor);
    }
    return *shared_executor;
  }

  [[nodiscard]] static ComponentInfo info_of(const Record& record) {
    ComponentInfo info;
    info.id = record.id;
    info.node = record.runtime->identity().fully_qualified();
    info.plugin = record.plugin;
    info.library = record.library->file();
    info.managed = record.managed != nullptr;
    info.state = record.managed != nullptr ? record.managed->get_current_state().state() : StateId::Unknown;
    info.fault = *record.fault.lock();
    return info;
  }

  [[nodiscard]] std::shared_ptr<Record> record(std::uint64_t id) const {
    const std::lock_guard lock(mutex);
    const auto found = records.find(id);
    return found == records.end() ? nullptr : found->second;
  }

  void note_fault(Record& record, const std::string& code, const std::string& text) {
    {
      auto fault = record.fault.lock();
      if (!fault->code.empty()) return;  // the first one is the cause
      *fault = {code, text};
    }
    record.runtime->write_safe_stop();
    log.error("{} is faulted: {}: {}", record.runtime->identity().fully_qualified(), code, text);
    if (code == "HUNG") {
      // Its code cannot be run any more; what can be done from outside is done.
      record.hung = true;
      record.runtime->set_active(false);
      tell_listener(record);
    } else {
      record.runtime->post([this, &record, reason = FaultReason{code, text}] {
        if (record.managed != nullptr) static_cast<void>(record.managed->process_fault(reason));
        tell_listener(record);
      });
    }
  }

  void tell_listener(Record& record) {
    std::function<void(const ComponentInfo&)> listener = *fault_listener.lock();
    if (listener) listener(info_of(record));
  }

  // Closes images whose last message has come home.
  void sweep_images() {
    const std::lock_guard lock(mutex);
    std::erase_if(kept_images, [&](const KeptImage& kept) { return commons.broker.sweep(kept.node).empty(); });
  }
};

Container::Container(ContainerOptions options, const Clock& clock)
    : impl_(std::make_unique<Impl>(std::move(options), clock)) {}

Container::~Container() {
  for (;;) {
    std::uint64_t last = 0;
    {
      const std::lock_guard lock(impl_->mutex);
      if (!impl_->records.empty()) last = impl_->records.rbegin()->first;
    }
    if (last == 0) break;
    static_cast<void>(unload(last));
  }
  // A thread that hangs in a component cannot be joined, and what it uses must stay: the process ends with it.
  if (!impl_->abandoned.empty()) {
    impl_->log.error("{} component(s) hang; their threads end with the process", impl_->abandoned.size());
    static_cast<void>(impl_.release());
    return;
  }
  if (impl_->shared_executor) impl_->supervisor.remove(*impl_->shared_executor);
}

const ContainerOptions& Container::options() const { return impl_->options; }
const Clock& Container::clock() const { return impl_->commons.clock; }
Transport& Container::transport() { return impl_->commons.broker; }

std::unique_ptr<NodeHost> Container::create_host(const NodeIdentity& identity) {
  if (making.record == nullptr || making.record->runtime) {
    throw std::logic_error("a node of this container is made by Container::load(), one per component");
  }
  Record& record = *making.record;
  {
    const std::lock_guard lock(impl_->mutex);
    for (const auto& [id, other] : impl_->records) {
      if (other->runtime->identity().fully_qualified() == identity.fully_qualified()) {
        throw exceptions::InvalidNameError(fmt::format(
            "a node {} is loaded already (component {}); give this one another name", identity.fully_qualified(), id));
      }
    }
  }
  auto on_fault = [impl = impl_.get(), &record](const std::string& code, const std::string& text) {
    impl->note_fault(record, code, text);
  };
  record.runtime = std::make_shared<NodeRuntime>(impl_->commons, identity, *making.executor, std::move(on_fault));
  return std::make_unique<Host>(record.runtime);
}

Result<ComponentInfo, Problem> Container::load(const LoadRequest& request) {
  impl_->sweep_images();
  const std::string where =
      request.name.empty() ? request.plugin : "component " + request.name + " (" + request.plugin + ")";
  const auto plugins = find_plugins(impl_->options.component_path);
  const auto entry = std::ranges::find(plugins, request.plugin, &PluginEntry::class_name);
  if (entry == plugins.end()) {
    std::vector<std::string> names;
    for (const auto& plugin : plugins) names.push_back(plugin.class_name);
    return err(Problem{where,
                       "there is no plugin " + request.plugin + " in " + join(impl_->options.component_path, ":"),
                       suggestion(request.plugin, names)});
  }
  auto library = PluginLibrary::open(entry->file);
  if (!library) return err(Problem{where, library.error().where + " " + library.error().what, library.error().way_out});

  auto record = std::make_shared<Record>();
  record->plugin = request.plugin;
  record->library = std::move(library).value();
  record->made_by = record->library->find(request.plugin);
  if (record->made_by == nullptr) {
    return err(Problem{where, entry->file + " holds no class " + request.plugin,
                       "it holds " + join(record->library->class_names())});
  }
  NodeOptions options{*this};
  options.node_name(request.name).node_namespace(request.name_space).parameter_overrides(request.parameters);
  options.remap_rules(request.remaps).qos_overrides(request.qos);

  std::string failure;
  making = {record.get(), &impl_->executor_for(*record, request)};
  try {
    record->node = record->made_by->create(options);
  } catch (const std::exception& e) { failure = e.what(); } catch (...) {
    failure = "an exception that is no std::exception";
  }
  making = {};
  if (record->node == nullptr || !record->runtime) {
    if (record->own_executor) impl_->supervisor.remove(*record->own_executor);
    return err(Problem{where, "its constructor failed: " + (failure.empty() ? "it made no node" : failure), ""});
  }
  record->managed = dynamic_cast<LifecycleNode*>(record->node);
  std::vector<std::string> warnings;
  for (const auto& name : record->node->parameters().unused_overrides()) {
    warnings.push_back(fmt::format("{}: parameter '{}' is given but the component has no such parameter; {}",
                                   record->runtime->identity().fully_qualified(), name,
                                   suggestion(name, record->node->parameters().list())));
    impl_->log.warn("{}", warnings.back());
  }
  const std::lock_guard lock(impl_->mutex);
  record->id = impl_->next_id++;
  impl_->records.emplace(record->id, record);
  ComponentInfo info = Impl::info_of(*record);
  info.warnings = std::move(warnings);
  return info;
}

Result<UnloadOutcome, Problem> Container::unload(std::uint64_t id) {
  const auto record = impl_->record(id);
  if (!record) return err(Problem{"component " + std::to_string(id), "is not loaded", "see `nacelle component list`"});
  const std::lock_guard alone(record->one_at_a_time);
  const std::string name = record->runtime->identity().fully_qualified();
  if (record->node == nullptr) return err(Problem{"component " + std::to_string(id), "is not loaded any more", ""});
  const MonotonicTime deadline = impl_->commons.clock.now() + impl_->options.transition_timeout;
  if (record->managed != nullptr && !record->hung) {
    // The component puts its hardware to rest itself; what it answers does not change that it goes.
    static_cast<void>(record->runtime->run_and_wait(
        [record] {
          LifecycleNode& node = *record->managed;
          if (node.get_current_state().state() == StateId::Active)
            static_cast<void>(node.trigger(Transition::Deactivate));
          if (node.get_current_state().state() == StateId::Inactive)
            static_cast<void>(node.trigger(Transition::Cleanup));
        },
        deadline));
  }
  record->runtime->set_active(false);
  const bool returned = record->runtime->group().executor().close(record->runtime->group(),
                                                                  record->hung ? impl_->commons.clock.now() : deadline);
  record->runtime->write_safe_stop();
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->records.erase(id);
    if (!returned) {
      impl_->abandoned.push_back(record);
      return UnloadOutcome{false, "a callback that has not returned"};
    }
  }
  record->made_by->destroy(std::exchange(record->node, nullptr));
  if (record->own_executor) {
    impl_->supervisor.remove(*record->own_executor);
    record->runtime.reset();
    record->own_executor.reset();
  }
  const std::string file = record->library->file();
  if (std::string held = impl_->commons.broker.sweep(name); !held.empty()) {
    const std::lock_guard lock(impl_->mutex);
    impl_->kept_images.push_back({name, std::move(record->library)});
    return UnloadOutcome{false, std::move(held)};
  }
  record->library.reset();
  if (!PluginLibrary::is_loaded(file)) return UnloadOutcome{true, {}};
  const std::lock_guard lock(impl_->mutex);
  for (const auto& [other_id, other] : impl_->records) {
    if (other->library->file() == file)
      return UnloadOutcome{false, fmt::format("another instance ({}, component {})",
                                              other->runtime->identity().fully_qualified(), other_id)};
  }
  return UnloadOutcome{false, "the process (the library is pinned: is it built with -fno-gnu-unique?)"};
}

std::vector<ComponentInfo> Container::list() const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<ComponentInfo> all;
  for (const auto& [id, record] : impl_->records) all.push_back(Impl::info_of(*record));
  return all;
}

Result<ComponentInfo, Problem> Container::find(const std::string& name_or_id) const {
  std::vector<ComponentInfo> hits;
  std::vector<std::string> names;
  for (auto& info : list()) {
    names.push_back(info.node);
    const std::string last = info.node.substr(info.node.rfind('/') + 1);
    if (info.node == name_or_id || last == name_or_id || std::to_string(info.id) == name_or_id)
      hits.push_back(std::move(info));
  }
  if (hits.size() == 1) return std::move(hits.front());
  if (hits.empty())
    return err(Problem{"component '" + name_or_id + "'", "is not loaded", suggestion(name_or_id, names)});
  std::vector<std::string> choices;
  for (const auto& hit : hits) choices.push_back(hit.node);
  return err(
      Problem{"component '" + name_or_id + "'", "could be any of " + join(choices), "give the full name or the id"});
}

TransitionOutcome Container::trigger(std::uint64_t id, Transition transition) {
  const auto record = impl_->record(id);
  if (!record) return {false, StateId::Unknown, "component " + std::to_string(id) + " is not loaded"};
  if (record->managed == nullptr)
    return {false, StateId::Unknown,
            record->runtime->identity().fully_qualified() + " is a plain node without a lifecycle"};
  const std::lock_guard alone(record->one_at_a_time);
  if (record->node == nullptr) return {false, StateId::Unknown, "it was unloaded meanwhile"};
  if (record->hung) return {false, StateId::Finalized, "it hangs: " + record->fault.lock()->text};
  // Shared with the task: if the component hangs, the task outlives this call.
  const auto outcome = std::make_shared<TransitionOutcome>();
  const Duration limit = impl_->options.transition_timeout;
  const bool ended = record->runtime->run_and_wait(
      [record, transition, outcome] {
        *outcome = record->managed->trigger(transition);
        if (outcome->success && transition == Transition::Configure) *record->fault.lock() = {};
      },
      impl_->commons.clock.now() + limit);
  if (ended) return *outcome;
  return {false, record->managed->get_current_state().state(),
          fmt::format("on_{} has not returned within {:.0f} s", to_text(transition), to_seconds(limit))};
}

std::vector<ClashReport> Container::clashes() const { return impl_->commons.broker.clashes(); }

std::vector<Problem> Container::frame_conflicts() const { return impl_->commons.frames.conflicts(); }

void Container::report_streams(std::vector<StreamReport>& out) const { impl_->commons.broker.report(out); }

void Container::report_histograms(std::vector<HistogramReport>& out) const {
  const std::lock_guard lock(impl_->mutex);
  std::size_t used = 0;
  for (const auto& [id, record] : impl_->records) record->runtime->report_histograms(out, used);
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

void Container::write_safe_stops() const {
  const std::lock_guard lock(impl_->mutex);
  for (const auto& [id, record] : impl_->records) record->runtime->write_safe_stop();
}

void Container::on_fault(std::function<void(const ComponentInfo&)> callback) {
  *impl_->fault_listener.lock() = std::move(callback);
}

}  // namespace nacelle::runtime
