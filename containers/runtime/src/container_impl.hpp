// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "container_services.hpp"
#include "errand.hpp"
#include "fault_history.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/host/state_watch.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/foreign_component.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "node_runtime.hpp"
#include "node_services.hpp"
#include "parameter_events.hpp"
#include "supervisor.hpp"

namespace nacelle::runtime {

/// Thrown to a constructor whose node's name is taken.
struct NameTaken : exceptions::InvalidNameError {
  using InvalidNameError::InvalidNameError;
};

/// A node of a component, and what its container offers on its behalf.
struct NodeRecord {
  std::uint64_t id = 0;  // of the component, or a number of no component
  std::shared_ptr<NodeRuntime> runtime;
  ParameterStore* parameters = nullptr;
  std::shared_ptr<ParameterEvents> events;  // the node's standard topic ...
  std::shared_ptr<NodeFace> face;           // ... and services; null if it has none
  Mutex offering;                           // guards offering and withdrawing these
  enum class Offer : std::uint8_t { None, Standing, Over } offer NACELLE_GUARDED_BY(offering) = Offer::None;
};

/// One component from the start of its load until its image is closed, and the node that is the component. The nodes
/// are destroyed first, the image is closed last.
struct Record : NodeRecord {
  std::string plugin, file, package;
  std::unique_ptr<PluginLibrary> library;
  std::unique_ptr<Executor> own_executor;
  std::unique_ptr<Context> context;  // makes its nodes
  const ComponentClass* made_by = nullptr;
  Guarded<std::vector<std::shared_ptr<NodeRecord>>> others;  // nodes beside it
  Guarded<std::vector<std::string>> node_names;              // of all that it has had
  Node* node = nullptr;
  LifecycleNode* managed = nullptr;
  std::vector<bool> used_remaps;  // by its constructor
  Mutex one_at_a_time;            // transitions and unloading of this component
  Guarded<FaultReason> fault;
  struct OpenFault {
    FaultReason reason;
    MonotonicTime since;
  };
  Guarded<std::vector<OpenFault>> open_faults;
  Guarded<LoadRequest> request;  // as it was loaded, with its present parameters
  std::atomic<bool> hung{false};

  // For loading and unloading. The container's lock guards given_up, and runtime while it is set or cleared.
  std::unique_ptr<Errand> errand;
  std::optional<Problem> failure;
  bool given_up = false;
  std::atomic<const char*> busy_with{""};  // the call that has not returned, for display

  /// Returns whether one of its nodes has ever registered a stop frame.
  [[nodiscard]] bool is_actuator() const;
  /// Calls `visit` with each of its nodes, its own first. No node ends meanwhile; code of the component must not run.
  template <typename F>
  void for_each_node(F&& visit) const {
    if (runtime) visit(*runtime);
    auto beside = others.lock();
    for (const auto& other : *beside) visit(*other->runtime);
  }
  /// Returns its nodes, its own first.
  [[nodiscard]] std::vector<std::shared_ptr<NodeRuntime>> runtimes() const;
};

/// Returns a node's present parameters, also while one of its callbacks runs. Threads: any.
[[nodiscard]] std::vector<ParameterReport> report_of(const ParameterStore& store);
/// Sets parameters, with rclcpp's texts, one result each or, `atomically`, one for all; calls `on_set` with those that
/// were set.
[[nodiscard]] std::vector<SetParametersResult> set_in(ParameterStore& store, const std::vector<Parameter>& parameters,
                                                      bool atomically,
                                                      const std::function<void(const std::vector<Parameter>&)>& on_set);

/// The container's data about its components. Threads: any.
struct Container::Impl {
  Impl(Container& self, ContainerOptions o, const Clock& clock)
      : options(std::move(o)),
        commons(clock, options.run_by_caller ? Watching::ByCaller : Watching::ByThread,
                fully_qualified_node_name(options.name_space, options.name)),
        supervisor({options.handover_after, options.hang_after}),
        index(options.component_path),
        node_services(
            options.node_interfaces == NodeInterfaces::None
                ? nullptr
                : std::make_unique<NodeServices>(self, commons, options.node_interfaces,
                                                 ContainerServices::node_of(options.name, options.name_space))),
        services(std::make_unique<ContainerServices>(self, commons, options.name, options.name_space,
                                                     node_services ? &node_services->executor() : nullptr)) {}

  const ContainerOptions options;
  const Logger log{"container"};
  Commons commons;
  Supervisor supervisor;
  PluginIndex index;
  // Made with the first component that shares it. Not guarded by `mutex`: the supervisor calls the container under its
  // own lock, which Supervisor::add() takes.
  Guarded<std::unique_ptr<Executor>> shared_executor;
  mutable Mutex mutex;  // component code must not run under it
  std::map<std::uint64_t, std::shared_ptr<Record>> records NACELLE_GUARDED_BY(mutex);
  std::map<std::uint64_t, std::shared_ptr<ForeignComponent>> foreign NACELLE_GUARDED_BY(mutex);  // of other processes
  // Their lifecycle services.
  std::map<std::uint64_t, std::shared_ptr<NodeFace>> foreign_faces NACELLE_GUARDED_BY(mutex);
  // Of nodes that are loaded, being loaded or being unloaded.
  std::map<std::string, const Record*> names NACELLE_GUARDED_BY(mutex);
  std::vector<std::shared_ptr<Record>> abandoned NACELLE_GUARDED_BY(mutex);  // their code has not returned
  struct HeldImage {
    KeptImage about;
    std::vector<std::string> nodes;          // of the component
    std::unique_ptr<PluginLibrary> library;  // held by messages; null if it is closed, and the process holds the image
    std::string image;
  };
  std::vector<HeldImage> held_images NACELLE_GUARDED_BY(mutex);
  std::uint64_t next_id NACELLE_GUARDED_BY(mutex) = 1;
  std::uint64_t next_other_id NACELLE_GUARDED_BY(mutex) = std::uint64_t{1} << 63U;  // of nodes beside components
  Guarded<std::function<void(const ComponentInfo&)>> fault_listener;
  Guarded<std::function<void(const StateChange&)>> state_listener;
  Guarded<std::function<void(const FaultEvent&)>> open_fault_listener;
  Guarded<std::function<void()>> change_listener;
  Guarded<FaultHistory> history{std::in_place, commons.facts};
  std::unique_ptr<NodeServices> node_services;  // null if they are disabled
  std::unique_ptr<ContainerServices> services;

  Patience patience{options.transition_timeout, commons.clock};

  [[nodiscard]] Duration transition_limit() const { return patience.limit(); }
  [[nodiscard]] Deadline deadline() const { return Deadline{patience}; }
  [[nodiscard]] Executor& executor_for(Record& record, const LoadRequest& request);
  [[nodiscard]] static ComponentInfo info_of(const Record& record);
  [[nodiscard]] std::shared_ptr<Record> record(std::uint64_t id) const;
  [[nodiscard]] std::shared_ptr<ForeignComponent> foreign_component(std::uint64_t id) const;
  /// The data about a component that a request to it needs, read at one time.
  struct Asked {
    std::shared_ptr<Record> record;  // null if it is not loaded
    std::string node;
    StateId state = StateId::Unknown;
    std::string why_not_wait;  // empty if this thread may wait for it; else it would wait for itself
  };
  [[nodiscard]] Asked ask_for(std::uint64_t id) const;
  [[nodiscard]] Result<void, Problem> post_to(std::uint64_t id, const char* name,
                                              std::function<void(Record&, NodeRecord&)> what);
  /// Returns its present parameters, also while a callback runs. Errors: it is not loaded here.
  [[nodiscard]] Result<std::vector<ParameterReport>, Problem> parameters_of(std::uint64_t id) const;
  /// Implements NodeServices::set_parameters().
  void change_parameters(std::uint64_t id, std::vector<Parameter> parameters, bool atomically,
                         std::weak_ptr<void> asker, const NodeServices::Then& then);
  void note_open_fault(Record& record, const std::string& code, const std::string& text, const std::string& callback);
  void note_closed_fault(Record& record, const std::string& code);
  /// Records it in history and log, and calls the listener.
  void tell_open_fault(FaultEvent event);
  void note_fault(Record& record, const std::string& code, const std::string& text, const std::string& callback);
  /// Records the cause of a fault: the first reason since it was last healthy. Returns false for a later reason.
  bool keep_reason(Record& record, const std::string& code, const std::string& text, const std::string& callback);
  /// Does what is possible without the code of a component, when that can no longer run.
  void give_up_on(Record& record);
  void note_failed_transition(Record& record, Transition transition, const TransitionOutcome& outcome);
  [[nodiscard]] StateWatch watch_states(const Record& record);
  void note_change() const;
  void write_safe_stops() const;
  /// Makes a component that moves something ignore commands, and writes its stop frame.
  void stop_what_moves() const;
  void tell_listener(Record& record);

  // Nodes of components (component_nodes.cpp).
  class ComponentContext;
  class OwnHost;
  class OtherHost;
  [[nodiscard]] std::unique_ptr<Context> context_for(Record& record, Executor& executor, bool uses_sim_time);
  /// Begins the standard services of a node, and lets its callbacks run.
  void offer(NodeRecord& node, bool has_lifecycle) const;
  /// Disables offer() for a node. Returns false if it was disabled already.
  [[nodiscard]] static bool refuse_offer(NodeRecord& node);
  /// Ends the standard services of a node. `returned`: none of its callbacks runs any more.
  void withdraw(NodeRecord& node, bool returned) const;
  void begin_other(Record& record, const std::shared_ptr<NodeRecord>& node);
  void end_other(Record& record, const std::shared_ptr<NodeRecord>& node);
  /// Returns the component that a node belongs to, and the node; nulls for an unknown id.
  struct Found {
    Record* record = nullptr;
    NodeRecord* node = nullptr;
  };
  [[nodiscard]] Found find_node(std::uint64_t id) const NACELLE_REQUIRES(mutex);

  // Loading and unloading (loading.cpp).
  void release_names(const Record& record);
  void make(Record& record, const LoadRequest& request);
  [[nodiscard]] static std::shared_ptr<const Declarations> declarations_of(const Record& record);
  void abandon(const std::shared_ptr<Record>& record);
  /// Closes a node. Returns false if a callback of it still runs at the deadline.
  [[nodiscard]] bool close(NodeRuntime& node, const Deadline& deadline) const;
  /// Returns false if no thread can be started for it.
  [[nodiscard]] bool start_destroying(const std::shared_ptr<Record>& record);
  [[nodiscard]] UnloadOutcome finish(const std::shared_ptr<Record>& unloaded);
  void sweep();
};

}  // namespace nacelle::runtime
