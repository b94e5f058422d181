// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/container.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>

#include "container_services.hpp"
#include "errand.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "node_runtime.hpp"
#include "supervisor.hpp"

namespace nacelle::runtime {
namespace {

using CallbackGroupPointer = NodeRuntime::GroupPointer;

// What Node sees: the runtime half outlives it by as long as the container needs.
class Host final : public NodeHost {
 public:
  explicit Host(std::shared_ptr<NodeRuntime> node) : node_(std::move(node)) {}
  const Clock& clock() const override { return node_->commons().clock; }
  std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) override { return node_->create_writer(spec); }
  std::unique_ptr<SubscriptionHandle> create_subscription(const EndpointSpec& spec, Taking taking,
                                                          MessageCallback callback,
                                                          const CallbackGroupPointer& group) override {
    return node_->create_subscription(spec, taking, callback, group);
  }
  std::unique_ptr<StatusEventHandle> create_status_event(PlainCallback callback,
                                                         const CallbackGroup::SharedPtr& group) override {
    return node_->create_status_event(callback, group);
  }
  std::unique_ptr<TimerHandle> create_timer(Duration period, PlainCallback callback,
                                            const CallbackGroupPointer& group) override {
    return node_->create_timer(period, callback, group);
  }
  std::unique_ptr<ServiceHandle> create_service(const std::string& name, const msgs::MessageType& request,
                                                const msgs::MessageType& response, ServiceCallback callback,
                                                const CallbackGroupPointer& group) override {
    return node_->create_service(name, request, response, callback, group);
  }
  std::unique_ptr<ClientHandle> create_client(const std::string& name, const msgs::MessageType& request,
                                              const msgs::MessageType& response, ResponseCallback callback,
                                              const CallbackGroupPointer& group) override {
    return node_->create_client(name, request, response, callback, group);
  }
  CallbackGroupPointer create_callback_group(CallbackGroupType type) override {
    return node_->create_callback_group(type);
  }
  std::unique_ptr<FrameClaim> claim_frame(const std::string& parent, const std::string& child,
                                          FrameClaimKind kind) override {
    return node_->commons().frames.claim(node_->identity().fully_qualified(), parent, child, kind);
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
  void set_active(bool active) override { node_->set_active(active); }

 private:
  const std::shared_ptr<NodeRuntime> node_;
};

// One component from the begin of its load to the close of its image. The node goes first, the image last.
struct Record {
  std::uint64_t id = 0;
  std::string plugin, file;
  std::unique_ptr<PluginLibrary> library;
  std::unique_ptr<Executor> own_executor;
  const ComponentClass* made_by = nullptr;
  std::shared_ptr<NodeRuntime> runtime;
  Node* node = nullptr;
  LifecycleNode* managed = nullptr;
  std::mutex one_at_a_time;  // transitions and unloading of this component
  Guarded<FaultReason> fault;
  std::atomic<bool> hung{false};

  // Of loading and unloading. The container's lock covers given_up, and runtime while the load goes on.
  std::unique_ptr<Errand> errand;
  std::optional<Problem> failure;
  bool given_up = false;
  std::atomic<const char*> busy_with{""};  // what has not returned, for people
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

struct Container::Impl final : Context {
  Impl(Container& self, ContainerOptions o, const Clock& clock)
      : options(std::move(o)),
        commons(clock),
        supervisor({options.handover_after, options.hang_after}),
        index(options.component_path),
        services(std::make_unique<ContainerServices>(self, commons, options.name)) {}

  const ContainerOptions options;
  const Logger log{"container"};
  Commons commons;
  Supervisor supervisor;
  PluginIndex index;
  std::unique_ptr<Executor> shared_executor;  // made with the first component that shares it
  mutable std::mutex mutex;  // what follows, and the shared executor; no code of a component runs under it
  std::map<std::uint64_t, std::shared_ptr<Record>> records;
  std::map<std::string, const Record*> names;      // of nodes that are loaded, being loaded or being unloaded
  std::vector<std::shared_ptr<Record>> abandoned;  // their code has not returned
  struct HeldImage {
    KeptImage about;
    std::unique_ptr<PluginLibrary> library;  // held by messages; null: it is closed, and the process holds the image
    std::string image;
  };
  std::vector<HeldImage> held_images;
  std::uint64_t next_id = 1;
  Guarded<std::function<void(const ComponentInfo&)>> fault_listener;
  std::unique_ptr<ContainerServices> services;

  [[nodiscard]] MonotonicTime deadline() const { return commons.clock.now() + options.transition_timeout; }

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
    info.library = record.file;
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

  // --- loading ------------------------------------------------------------------------------------------------------------

  std::unique_ptr<NodeHost> create_host(const NodeIdentity& identity) override {
    if (making.record == nullptr || making.record->runtime) {
      throw std::logic_error("a node of this container is made by Container::load(), one per component");
    }
    Record& record = *making.record;
    const std::string name = identity.fully_qualified();
    auto on_fault = [this, &record](const std::string& code, const std::string& text) {
      note_fault(record, code, text);
    };
    auto runtime = std::make_shared<NodeRuntime>(commons, identity, *making.executor, std::move(on_fault));
    const std::lock_guard lock(mutex);
    if (record.given_up) throw std::runtime_error("its load was given up");
    if (const auto [taken, is_new] = names.emplace(name, &record); !is_new) {
      const std::uint64_t id = taken->second->id;
      throw exceptions::InvalidNameError(
          id != 0 ? fmt::format("a node {} is loaded already (component {}); give this one another name", name, id)
                  : fmt::format("a node {} is being loaded just now; give this one another name", name));
    }
    record.runtime = std::move(runtime);
    return std::make_unique<Host>(record.runtime);
  }

  void release_name(const Record& record) {
    const std::lock_guard lock(mutex);
    std::erase_if(names, [&](const auto& entry) { return entry.second == &record; });
  }

  // On the errand's thread: all of a load that runs code of the library.
  void make(Record& record, const LoadRequest& request) {
    record.busy_with = "its library's start-up code, which has not returned";
    auto library = PluginLibrary::open(record.file);
    if (!library) {
      record.failure = Problem{"", library.error().where + " " + library.error().what, library.error().way_out};
      return;
    }
    record.library = std::move(library).value();
    record.made_by = record.library->find(request.plugin);
    if (record.made_by == nullptr) {
      record.failure = Problem{"", record.file + " holds no class " + request.plugin,
                               "it holds " + join(record.library->class_names())};
      return;
    }
    NodeOptions node_options{*this};
    node_options.node_name(request.name).node_namespace(request.name_space).parameter_overrides(request.parameters);
    node_options.remap_rules(request.remaps).qos_overrides(request.qos);
    record.busy_with = "its constructor, which has not returned";
    Node* node = nullptr;
    std::string failed;
    making = {&record, &executor_for(record, request)};
    try {
      node = record.made_by->create(node_options);
    } catch (const std::exception& e) { failed = e.what(); } catch (...) {
      failed = "an exception that is no std::exception";
    }
    making = {};
    if (node == nullptr || !record.runtime) {
      if (node != nullptr) record.made_by->destroy(node);
      record.failure = Problem{"", "its constructor failed: " + (failed.empty() ? "it made no node" : failed), ""};
      return;
    }
    bool wanted = true;
    {
      const std::lock_guard lock(mutex);
      wanted = !record.given_up;
      if (wanted) record.node = node;
    }
    if (!wanted) record.made_by->destroy(node);  // too late: whoever asked for it has been told that it failed
  }

  // --- unloading ----------------------------------------------------------------------------------------------------------

  // Its code has not returned. What can be done without running it is done; the rest follows when it returns (sweep).
  void abandon(const std::shared_ptr<Record>& record) {
    std::shared_ptr<NodeRuntime> runtime;
    {
      const std::lock_guard lock(mutex);
      record->given_up = true;
      runtime = record->runtime;
      abandoned.push_back(record);
    }
    if (runtime) {
      static_cast<void>(runtime->close(commons.clock.now()));
      runtime->withdraw();
      runtime->write_safe_stop();
    }
    release_name(*record);
  }

  void start_destroying(const std::shared_ptr<Record>& record) {
    record->busy_with = "its destructor, which has not returned";
    record->errand = std::make_unique<Errand>(
        "unload", [record] { record->made_by->destroy(std::exchange(record->node, nullptr)); });
  }

  // The node is gone: its executor goes, and the image too unless somebody holds it.
  UnloadOutcome finish(Record& record) {
    const std::string node = record.runtime ? record.runtime->identity().fully_qualified() : record.plugin;
    if (record.own_executor) supervisor.remove(*record.own_executor);
    supervisor.settle();
    record.runtime.reset();
    record.own_executor.reset();
    release_name(record);
    if (!record.library) return {true, {}};
    if (std::string held = commons.broker.sweep(node); !held.empty()) {
      const std::lock_guard lock(mutex);
      const std::string image = record.library->image();
      held_images.push_back({{node, record.plugin, record.file, held}, std::move(record.library), image});
      return {false, std::move(held)};
    }
    const std::string image = record.library->image();
    record.library.reset();
    if (!PluginLibrary::is_mapped(image)) return {true, {}};
    const std::lock_guard lock(mutex);
    for (const auto& [id, other] : records) {
      if (other->library->image() == image) {
        return {false,
                fmt::format("another instance ({}, component {})", other->runtime->identity().fully_qualified(), id)};
      }
    }
    for (const auto& held : held_images) {
      if (held.image == image) return {false, held.about.held_by};
    }
    for (const auto& other : abandoned) {
      if (other->file == record.file) return {false, "another instance: " + std::string(other->busy_with.load())};
    }
    std::string held_by =
        "the process (by thread-locals of threads that go on, or a symbol built without -fno-gnu-unique)";
    held_images.push_back({{node, record.plugin, record.file, held_by}, nullptr, image});
    return {false, std::move(held_by)};
  }

  // Ends what was abandoned and has returned since, and closes images whose last message has come home.
  void sweep() {
    std::vector<std::shared_ptr<Record>> returned;
    {
      const std::lock_guard lock(mutex);
      std::erase_if(abandoned, [&](const std::shared_ptr<Record>& record) {
        if (record->errand) {
          if (!record->errand->has_ended()) return false;
        } else if (!record->runtime->close(commons.clock.now())) {
          return false;
        }
        returned.push_back(record);
        return true;
      });
    }
    for (const auto& record : returned) {
      record->errand.reset();
      if (record->node != nullptr) {
        start_destroying(record);
        if (!record->errand->wait(commons.clock,
                                  commons.clock.now() + std::min<Duration>(1s, options.transition_timeout))) {
          const std::lock_guard lock(mutex);
          abandoned.push_back(record);
          continue;
        }
        record->errand.reset();
      }
      static_cast<void>(finish(*record));
    }
    std::vector<HeldImage> free;  // closed without the lock: a library may have code that runs then
    const std::lock_guard lock(mutex);
    std::erase_if(held_images, [&](HeldImage& held) {
      if (!held.library) return !PluginLibrary::is_mapped(held.image);
      held.about.held_by = commons.broker.sweep(held.about.node);
      if (!held.about.held_by.empty()) return false;
      free.push_back(std::move(held));
      return true;
    });
  }
};

Container::Container(ContainerOptions options, const Clock& clock)
    : impl_(std::make_unique<Impl>(*this, std::move(options), clock)) {}

Container::~Container() {
  impl_->services.reset();  // nobody loads any more
  for (;;) {
    std::uint64_t last = 0;
    {
      const std::lock_guard lock(impl_->mutex);
      if (!impl_->records.empty()) last = impl_->records.rbegin()->first;
    }
    if (last == 0) break;
    static_cast<void>(unload(last));
  }
  impl_->sweep();
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

Result<ComponentInfo, Problem> Container::load(const LoadRequest& request) {
  impl_->sweep();
  const std::string where =
      request.name.empty() ? request.plugin : "component " + request.name + " (" + request.plugin + ")";
  const auto entry = impl_->index.find(request.plugin);
  if (!entry) {
    return err(Problem{where,
                       "there is no plugin " + request.plugin + " in " + join(impl_->options.component_path, ":"),
                       suggestion(request.plugin, impl_->index.class_names())});
  }
  const auto record = std::make_shared<Record>();
  record->plugin = request.plugin;
  record->file = entry->file;
  const MonotonicTime deadline = impl_->deadline();
  record->errand =
      std::make_unique<Errand>("load", [impl = impl_.get(), record, request] { impl->make(*record, request); });
  if (!record->errand->wait(impl_->commons.clock, deadline)) {
    const std::string busy_with = record->busy_with.load();
    impl_->abandon(record);
    return err(Problem{
        where, fmt::format("not loaded: {} within {:g} s", busy_with, to_seconds(impl_->options.transition_timeout)),
        "the others go on; its library stays until it returns"});
  }
  record->errand.reset();
  if (record->failure) {
    static_cast<void>(impl_->finish(*record));
    record->failure->where = where;
    return err(*record->failure);
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
  record->runtime->open();
  // All its endpoints are there now: types that clash can be told.
  static_cast<void>(impl_->commons.broker.watch(impl_->commons.clock.now()));
  ComponentInfo info = Impl::info_of(*record);
  info.warnings = std::move(warnings);
  return info;
}

Result<UnloadOutcome, Problem> Container::unload(std::uint64_t id) {
  impl_->sweep();
  const auto record = impl_->record(id);
  if (!record) return err(Problem{"component " + std::to_string(id), "is not loaded", "see `nacelle component list`"});
  if (std::string why = record->runtime->executor().why_not_wait_for(record->runtime->groups()); !why.empty())
    return err(Problem{record->runtime->identity().fully_qualified(), "cannot be unloaded from here", std::move(why)});
  const std::lock_guard alone(record->one_at_a_time);
  if (record->node == nullptr || record->given_up)
    return err(Problem{"component " + std::to_string(id), "is not loaded any more", ""});
  const MonotonicTime deadline = impl_->deadline();
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
  const bool returned = record->runtime->close(record->hung ? impl_->commons.clock.now() : deadline);
  record->runtime->write_safe_stop();
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->records.erase(id);
  }
  if (!returned) {
    record->busy_with = "a callback that has not returned";
    impl_->abandon(record);
    return UnloadOutcome{false, record->busy_with.load()};
  }
  impl_->start_destroying(record);
  if (!record->errand->wait(impl_->commons.clock, impl_->deadline())) {
    impl_->abandon(record);
    return UnloadOutcome{false, record->busy_with.load()};
  }
  record->errand.reset();
  return impl_->finish(*record);
}

std::vector<KeptImage> Container::kept_images() {
  impl_->sweep();
  std::vector<KeptImage> all;
  const std::lock_guard lock(impl_->mutex);
  for (const auto& held : impl_->held_images) all.push_back(held.about);
  for (const auto& record : impl_->abandoned) {
    all.push_back({record->runtime ? record->runtime->identity().fully_qualified() : record->plugin, record->plugin,
                   record->file, record->busy_with.load()});
  }
  return all;
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
  choices.reserve(hits.size());
  for (const auto& hit : hits) choices.push_back(hit.node);
  return err(
      Problem{"component '" + name_or_id + "'", "could be any of " + join(choices), "give the full name or the id"});
}

TransitionOutcome Container::trigger(std::uint64_t id, Transition transition) {
  const auto record = impl_->record(id);
  if (!record) return {false, StateId::Unknown, "component " + std::to_string(id) + " is not loaded"};
  if (std::string why = record->runtime->executor().why_not_wait_for(record->runtime->groups()); !why.empty())
    return {false, Impl::info_of(*record).state, "would wait for itself: " + why};
  const std::lock_guard alone(record->one_at_a_time);
  if (record->node == nullptr || record->given_up) return {false, StateId::Unknown, "it was unloaded meanwhile"};
  if (record->managed == nullptr)
    return {false, StateId::Unknown,
            record->runtime->identity().fully_qualified() + " is a plain node without a lifecycle"};
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
  if (ended) {
    static_cast<void>(impl_->commons.broker.watch(impl_->commons.clock.now()));  // on_configure may have made endpoints
    return *outcome;
  }
  return {false, record->managed->get_current_state().state(),
          fmt::format("on_{} has not returned within {:.0f} s", to_text(transition), to_seconds(limit))};
}

std::vector<ClashReport> Container::clashes() const { return impl_->commons.broker.clashes(); }

std::vector<Problem> Container::frame_conflicts() const { return impl_->commons.frames.conflicts(); }

WiringReport Container::wiring(const std::string& topic, Duration age) const {
  return impl_->commons.broker.wiring(topic, age);
}

std::vector<std::string> Container::topics_of(const std::string& node) const {
  return impl_->commons.broker.topics_of(node);
}

void Container::report_streams(std::vector<StreamReport>& out) const { impl_->commons.broker.report(out); }

void Container::report_histograms(std::vector<HistogramReport>& out) const {
  const std::lock_guard lock(impl_->mutex);
  std::size_t used = 0;
  for (const auto& [id, record] : impl_->records) record->runtime->report_histograms(out, used);
  out.resize(used);
}

void Container::report_callbacks(std::vector<CallbackReport>& out) const {
  const std::lock_guard lock(impl_->mutex);
  std::size_t used = 0;
  for (const auto& [id, record] : impl_->records) record->runtime->report_callbacks(out, used);
  out.resize(used);
}

void Container::report_threads(std::vector<ThreadReport>& out) const {
  const std::lock_guard lock(impl_->mutex);
  std::size_t used = 0;
  if (impl_->shared_executor) impl_->shared_executor->report_threads(out, used);
  for (const auto& [id, record] : impl_->records) {
    if (record->own_executor) record->own_executor->report_threads(out, used);
  }
  out.resize(used);
}

void Container::report_loads(std::vector<LoadReport>& out) const {
  const std::lock_guard lock(impl_->mutex);
  out.resize(impl_->records.size());
  auto row = out.begin();
  for (const auto& [id, record] : impl_->records) record->runtime->report_load(*row++);
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
