// SPDX-License-Identifier: Apache-2.0
// Loading and unloading of components: their code runs on its own thread, with a deadline (docs/adr/0005).
#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "container_impl.hpp"
#include "host.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/host/remap_notes.hpp"
#include "nacelle/runtime/plugin_fault.hpp"

namespace nacelle::runtime {
namespace {

bool uses_sim_time(const LoadRequest& request) {
  const auto found = request.parameters.find("use_sim_time");
  const bool* const value = found == request.parameters.end() ? nullptr : std::get_if<bool>(&found->second);
  return value != nullptr && *value;  // another type is refused when the node declares the parameter
}

}  // namespace

void Container::Impl::release_names(const Record& record) {
  const LockGuard lock(mutex);
  std::erase_if(names, [&](const auto& entry) {
    if (entry.second != &record) return false;
    forget_log_origin(entry.first);
    return true;
  });
}

// On the errand's thread: the part of a load that runs code of the library.
void Container::Impl::make(Record& record, const LoadRequest& request) {
  record.busy_with = "its library's start-up code, which has not returned";
  auto library = PluginLibrary::open(record.file);
  if (!library) {
    record.failure = Problem{"", library.error().where.text() + " " + library.error().what, library.error().way_out,
                             library.error().code, library.error().value};
    return;
  }
  record.library = std::move(library).value();
  record.made_by = record.library->find(request.plugin);
  if (record.made_by == nullptr) {
    record.failure =
        Problem{"", record.file + " holds no class " + request.plugin,
                "it holds " + join(record.library->class_names()), PluginFault::ClassNotInLibrary, request.plugin};
    return;
  }
  record.busy_with = "its constructor, which has not returned";
  Node* node = nullptr;
  std::string failed, value = request.plugin;
  ProblemCode code = PluginFault::FailedConstructor;
  const auto refuse_name = [&](const exceptions::InvalidNameError& e, NameFault fault) {
    failed = e.what();
    value = e.name;
    code = fault;
  };
  const RemapNotes remap_notes{request.remaps.size()};
  try {
    record.context = context_for(record, executor_for(record, request), uses_sim_time(request));
    NodeOptions node_options{*record.context};
    node_options.node_name(request.name).node_namespace(request.name_space).parameter_overrides(request.parameters);
    node_options.remap_rules(request.remaps).qos_overrides(request.qos).collect_parameter_faults(request.faults);
    node = record.made_by->create(node_options);
  } catch (const NameTaken& e) { refuse_name(e, NameFault::Taken); } catch (const exceptions::InvalidNameError& e) {
    refuse_name(e, NameFault::Invalid);
  } catch (const std::exception& e) { failed = e.what(); } catch (...) {
    failed = "unknown exception";
  }
  record.used_remaps = remap_notes.used();
  if (node == nullptr || !record.runtime) {
    if (node != nullptr) record.made_by->destroy(node);
    record.failure = Problem{"", "its constructor failed: " + (failed.empty() ? "it made no node" : failed), "",
                             std::move(code), std::move(value)};
    return;
  }
  bool wanted = true;
  {
    const LockGuard lock(mutex);
    wanted = !record.given_up;
    if (wanted) record.node = node;
  }
  if (!wanted) record.made_by->destroy(node);  // too late: the load has already failed for its requester
}

// Reads the constructor's declarations before the component runs, so that no other thread accesses its parameters.
std::shared_ptr<const Declarations> Container::Impl::declarations_of(const Record& record) {
  auto all = std::make_shared<Declarations>();
  const ParameterStore& store = record.node->parameters();
  for (const auto& name : store.list())
    all->parameters.push_back(
        {name, store.get(name), store.overrides().count(name) != 0, store.declared_type(name), store.describe(name)});
  all->unknown_parameters = store.unused_overrides();
  all->frame_uses = record.node->frame_uses();
  all->device_uses = record.node->device_uses();
  all->used_remaps = record.used_remaps;
  all->package = record.package;
  std::vector<CallbackReport> callbacks;
  std::size_t used = 0;
  record.for_each_node([&](const NodeRuntime& each) { each.report_callbacks(callbacks, used); });
  callbacks.resize(used);
  for (const auto& callback : callbacks) {
    if (callback.kind == "service") all->services.push_back(callback.name);
  }
  return all;
}

// --- unloading ----------------------------------------------------------------------------------------------------------

// Abandons a component whose code has not returned: does what is possible without running it. The rest follows when it
// returns (sweep).
void Container::Impl::abandon(const std::shared_ptr<Record>& record) {
  std::vector<std::shared_ptr<NodeRuntime>> runtimes;
  {
    const LockGuard lock(mutex);
    record->given_up = true;
    runtimes = record->runtimes();
    abandoned.push_back(record);
  }
  for (const auto& runtime : runtimes) {
    static_cast<void>(runtime->close(commons.clock.now()));
    runtime->withdraw();
    runtime->write_safe_stop();
    if (node_services) node_services->forget_log(runtime->identity().fully_qualified());
  }
  release_names(*record);
}

bool Container::Impl::close(NodeRuntime& node, const Deadline& deadline) const {
  constexpr Duration kTurn = 100ms;
  for (;;) {
    const MonotonicTime now = commons.clock.now(), end = deadline.now();
    if (node.close(std::min(now + kTurn, end))) return true;
    if (now >= end) return false;
    deadline.note_waiting();
  }
}

bool Container::Impl::start_destroying(const std::shared_ptr<Record>& record) {
  record->busy_with = "its destructor, which has not returned";
  try {
    record->errand = std::make_unique<Errand>(
        "unload", [record] { record->made_by->destroy(std::exchange(record->node, nullptr)); });
    return true;
  } catch (const std::system_error&) {
    record->busy_with = "its destructor, for which no thread can be started";
    return false;
  }
}

// Called when the node is destroyed: ends its executor, and closes the image unless it is still in use.
UnloadOutcome Container::Impl::finish(const std::shared_ptr<Record>& unloaded) {
  Record& record = *unloaded;
  if (!record.others.lock()->empty()) {
    record.busy_with = "a node that it made and has not destroyed";
    abandon(unloaded);
    return {false, record.busy_with.load()};
  }
  const std::string node = record.runtime ? record.runtime->identity().fully_qualified() : record.plugin;
  if (record.own_executor) supervisor.remove(*record.own_executor);
  supervisor.settle();
  // Taken out under the lock, for who asks why_not_wait_for(), and ended without it; the node's half before its executor.
  std::unique_ptr<Executor> executor;
  std::shared_ptr<NodeRuntime> runtime;
  {
    const LockGuard lock(mutex);
    executor = std::move(record.own_executor);
    runtime = std::move(record.runtime);
  }
  runtime.reset();
  executor.reset();
  release_names(record);
  if (!record.library) return {true, {}};
  std::vector<std::string> nodes = *record.node_names.lock();
  if (std::string held = commons.broker.sweep(nodes); !held.empty()) {
    const LockGuard lock(mutex);
    const std::string image = record.library->image();
    held_images.push_back(
        {{node, record.plugin, record.file, held}, std::move(nodes), std::move(record.library), image});
    return {false, std::move(held)};
  }
  const std::string image = record.library->image();
  record.library.reset();
  if (!PluginLibrary::is_mapped(image)) return {true, {}};
  const LockGuard lock(mutex);
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
  held_images.push_back({{node, record.plugin, record.file, held_by}, {}, nullptr, image});
  return {false, std::move(held_by)};
}

// Destroys abandoned components that have returned since, and closes images whose last message was released.
void Container::Impl::sweep() {
  std::vector<std::shared_ptr<Record>> returned;
  {
    const LockGuard lock(mutex);
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
      if (!start_destroying(record) ||
          !record->errand->wait(commons.clock,
                                Deadline{commons.clock.now() + std::min<Duration>(1s, transition_limit())})) {
        const LockGuard lock(mutex);
        abandoned.push_back(record);
        continue;
      }
      record->errand.reset();
    }
    static_cast<void>(finish(record));
  }
  std::vector<HeldImage> free;  // closed without the lock, because closing may run code of the library
  const LockGuard lock(mutex);
  std::erase_if(held_images, [&](HeldImage& held) {
    if (!held.library) return !PluginLibrary::is_mapped(held.image);
    held.about.held_by = commons.broker.sweep(held.nodes);
    if (!held.about.held_by.empty()) return false;
    free.push_back(std::move(held));
    return true;
  });
}

Result<ComponentInfo, Problem> Container::load(const LoadRequest& request) {
  impl_->sweep();
  // A client may send a name of any size, and names are repeated in messages and compared with all known ones.
  constexpr std::size_t kMostBytes = 255, kShown = 60;
  for (const std::string* const name : {&request.plugin, &request.name}) {
    if (name->size() > kMostBytes)
      return err(Problem{"component " + name->substr(0, kShown) + "...",
                         fmt::format("its {} has {} bytes; at most {} are allowed",
                                     name == &request.plugin ? "class name" : "name", name->size(), kMostBytes),
                         "", NameFault::Invalid, name->substr(0, kShown) + "..."});
  }
  const std::string where =
      request.name.empty() ? request.plugin : "component " + request.name + " (" + request.plugin + ")";
  const auto entry = impl_->index.find(request.plugin);
  if (!entry) {
    return err(
        Problem{where, "there is no plugin " + request.plugin + " in " + join(impl_->options.component_path, ":"),
                suggestion(request.plugin, impl_->index.class_names()), PluginFault::UnknownClass, request.plugin});
  }
  const auto record = std::make_shared<Record>();
  record->plugin = request.plugin;
  record->file = entry->file;
  record->package = entry->package;
  *record->request.lock() = request;
  const Deadline deadline = impl_->deadline();
  try {
    record->errand =
        std::make_unique<Errand>("load", [impl = impl_.get(), record, request] { impl->make(*record, request); });
  } catch (const std::system_error& failure) {
    return err(Problem{where, std::string{"not loaded: cannot start a thread: "} + failure.what(),
                       "raise `ulimit -u`, or TasksMax= of the service", PluginFault::NoThread, request.plugin});
  }
  if (!record->errand->wait(impl_->commons.clock, deadline)) {
    const std::string busy_with = record->busy_with.load();
    impl_->abandon(record);
    return err(
        Problem{where, fmt::format("not loaded: {} within {:g} s", busy_with, to_seconds(impl_->transition_limit())),
                "the others continue; its library stays until it returns", PluginFault::TimedOut, request.plugin});
  }
  record->errand.reset();
  if (record->failure) {
    if (record->runtime) impl_->withdraw(*record, true);
    static_cast<void>(impl_->finish(record));
    record->failure->where = where;
    return err(*record->failure);
  }
  record->managed = dynamic_cast<LifecycleNode*>(record->node);
  std::vector<std::string> warnings;
  for (const auto& name : record->node->parameters().unused_overrides()) {
    warnings.push_back(fmt::format("{}: parameter '{}' is given but the component has no such parameter; {}",
                                   record->runtime->identity().fully_qualified(), name,
                                   suggestion(name, record->node->parameters().list())));
    if (!request.faults) impl_->log.warn("{}", warnings.back());  // a caller that collects faults reports this one, too
  }
  auto declared = Impl::declarations_of(*record);
  {
    const LockGuard lock(impl_->mutex);
    record->id = impl_->next_id++;
  }
  std::vector<std::shared_ptr<NodeRecord>> others;
  ComponentInfo info;
  {
    // From here on a node that the component makes beside it begins by itself.
    const LockGuard lock(impl_->mutex);
    impl_->records.emplace(record->id, record);
    others = *record->others.lock();
    info = Impl::info_of(*record);
  }
  for (const auto& other : others) impl_->offer(*other, false);
  impl_->offer(*record, record->managed != nullptr);
  // All its endpoints exist now, so type clashes can be reported.
  static_cast<void>(impl_->commons.broker.watch(impl_->commons.clock.now()));
  info.warnings = std::move(warnings);
  info.declared = std::move(declared);
  impl_->note_change();
  return info;
}

Result<UnloadOutcome, Problem> Container::unload(std::uint64_t id) {
  impl_->sweep();
  if (const auto other = impl_->foreign_component(id)) {
    const UnloadOutcome outcome = other->unload();
    decltype(impl_->foreign_faces)::node_type face;
    {
      const LockGuard lock(impl_->mutex);
      impl_->foreign.erase(id);
      face = impl_->foreign_faces.extract(id);
    }
    if (!face.empty()) impl_->node_services->withdraw(id, face.mapped());
    impl_->note_change();
    return outcome;
  }
  const auto asked = impl_->ask_for(id);
  const auto& record = asked.record;
  if (!record)
    return err(Problem{"component " + std::to_string(id), "is not loaded", "see `nacelle component list`",
                       NameFault::Unknown, std::to_string(id)});
  if (!asked.why_not_wait.empty()) return err(Problem{asked.node, "cannot be unloaded from here", asked.why_not_wait});
  const LockGuard alone(record->one_at_a_time);
  if (record->given_up || record->node == nullptr)  // in this order, as in trigger()
    return err(Problem{"component " + std::to_string(id), "is not loaded any more", "", NameFault::Unknown,
                       std::to_string(id)});
  const Deadline deadline = impl_->deadline();
  if (record->managed != nullptr && !record->hung) {
    // The component stops its hardware itself; it is unloaded whatever its callbacks return.
    static_cast<void>(record->runtime->run_and_wait(
        "on_deactivate and on_cleanup",
        [impl = impl_.get(), record] {
          const StateWatch watch = impl->watch_states(*record);
          LifecycleNode& node = *record->managed;
          if (node.get_current_state().state() == StateId::Active)
            static_cast<void>(node.trigger(Transition::Deactivate));
          if (node.get_current_state().state() == StateId::Inactive)
            static_cast<void>(node.trigger(Transition::Cleanup));
        },
        deadline));
  }
  bool returned = true;
  for (const auto& runtime : record->runtimes()) {
    runtime->set_active(false);
    returned = impl_->close(*runtime, record->hung ? Deadline{impl_->commons.clock.now()} : deadline) && returned;
    runtime->write_safe_stop();
  }
  {
    const LockGuard lock(impl_->mutex);
    impl_->records.erase(id);
  }
  const std::vector<std::shared_ptr<NodeRecord>> others = *record->others.lock();
  for (const auto& other : others) impl_->withdraw(*other, returned);
  impl_->withdraw(*record, returned);
  impl_->note_change();
  if (!returned) {
    record->busy_with = "a callback that has not returned";
    impl_->abandon(record);
    return UnloadOutcome{false, record->busy_with.load()};
  }
  if (!impl_->start_destroying(record) || !record->errand->wait(impl_->commons.clock, impl_->deadline())) {
    impl_->abandon(record);
    return UnloadOutcome{false, record->busy_with.load()};
  }
  record->errand.reset();
  return impl_->finish(record);
}

std::vector<KeptImage> Container::kept_images() {
  impl_->sweep();
  std::vector<KeptImage> all;
  const LockGuard lock(impl_->mutex);
  for (const auto& held : impl_->held_images) all.push_back(held.about);
  for (const auto& record : impl_->abandoned) {
    all.push_back({record->runtime ? record->runtime->identity().fully_qualified() : record->plugin, record->plugin,
                   record->file, record->busy_with.load()});
  }
  return all;
}

std::size_t Container::abandoned() const {
  const LockGuard lock(impl_->mutex);
  return impl_->abandoned.size();
}

}  // namespace nacelle::runtime
