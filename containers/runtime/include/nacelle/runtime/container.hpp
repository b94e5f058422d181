// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/host/graph.hpp"
#include "nacelle/host/service_graph.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/runtime/component_info.hpp"
#include "nacelle/runtime/introspection.hpp"
#include "nacelle/runtime/reports.hpp"

namespace nacelle::runtime {

/// The standard topics and services that each component's node offers, as rclcpp's nodes do (docs/node_interfaces.md).
enum class NodeInterfaces : std::uint8_t {
  None,
  Isolated,  ///< /rosout, /parameter_events, services for parameters and types. Another container offers the lifecycle's.
  All,       ///< Also the lifecycle services, and services for parameters of the container's own node.
};

struct ContainerOptions {
  std::string name = "nacelle";
  std::string name_space = "/";             ///< The namespace of the container's own node.
  std::vector<std::string> component_path;  ///< Folders with plugin libraries and their index/.
  Duration handover_after = 20ms;           ///< A callback longer than this loses its executor to a spare thread.
  Duration hang_after = 1500ms;             ///< A callback longer than this faults its component.
  Duration transition_timeout =
      30s;  ///< A lifecycle callback, constructor or destructor that takes longer is abandoned.
  NodeInterfaces node_interfaces = NodeInterfaces::None;
  /// No thread runs callbacks: all components share one executor, which step() and the container's other functions run on their caller's
  /// thread. With a clock that is told the time, a run is the same each time.
  bool run_by_caller = false;
};

class CompositionHost;
class ForeignComponent;

/// Loads, runs and unloads components; one per process.
///
/// Component code runs on its executor or on the component's own thread, never on the caller's thread and never under a
/// lock. If it is slow or never returns, it delays only the caller that waits for it. The node /<options.name> offers
/// services of composition_interfaces and nacelle_interfaces below ~/_container to every component.
/// Threads: everything from any thread. load(), unload() and trigger() wait for the component, at most for
/// transition_timeout;
///          the others keep running meanwhile. From a callback that would wait for itself, unload() and trigger()
/// return an error instead.
class Container final {
 public:
  Container(ContainerOptions options, const Clock& clock);
  ~Container();
  Container(const Container&) = delete;
  Container& operator=(const Container&) = delete;

  [[nodiscard]] const ContainerOptions& options() const;
  /// Returns the full name of the container's own node.
  [[nodiscard]] std::string node() const;
  [[nodiscard]] const Clock& clock() const;
  /// Returns the in-process transport, for readers and writers that are not components (those of the control socket).
  [[nodiscard]] Transport& transport();
  /// Returns the graph of the same transport, for links to other processes.
  [[nodiscard]] Graph& graph();
  [[nodiscard]] ServiceHub& service_graph();

  /// Loads the library of a plugin and constructs the component.
  /// Errors: a PluginFault (plugin_fault.hpp); NameFault::Invalid and Taken. After TimedOut the image is kept, and the
  /// component is destroyed once its constructor has returned.
  [[nodiscard]] Result<ComponentInfo, Problem> load(const LoadRequest& request);
  /// Destroys the instance at once, and closes its library once nothing holds it (UnloadOutcome, kept_images()).
  [[nodiscard]] Result<UnloadOutcome, Problem> unload(std::uint64_t id);
  /// Adds a component of another process, which is then listed, found, triggered and unloaded like the others. Errors:
  /// its name is taken.
  [[nodiscard]] Result<ComponentInfo, Problem> adopt(std::shared_ptr<ForeignComponent> component);
  /// Makes the services of the container's node load and unload through `host` instead of load() and unload(); null:
  /// through these again. Waits for the running call, so the host must not block it. `host` must outlive its use.
  void compose_through(CompositionHost* host);
  /// Offers a service below ~/_container of the container's own node until the handle is destroyed. Its callbacks run
  /// one at a time on the thread of the nodes' standard services (docs/node_interfaces.md), so they must return soon
  /// and must not wait for a component.
  [[nodiscard]] std::unique_ptr<ServiceHandle> offer_service(const std::string& name, const msgs::MessageType& request,
                                                             const msgs::MessageType& response,
                                                             ServiceCallback callback);
  /// Reports that a component of another process has become faulted.
  void tell_fault(const ComponentInfo& info, const std::string& callback = {});
  /// Reports that an open fault of a component of another process has begun, or has ended (`lasted`).
  void tell_open_fault(const FaultEvent& event);
  /// Reports that a component of another process has entered a state, as is done for those of this process.
  void tell_state(const StateChange& change);
  /// Announces that the parameters of a foreign component have changed. Threads: any.
  void tell_change();
  /// Returns the last faults of each node in their order, also of components that were unloaded.
  [[nodiscard]] std::vector<FaultEvent> faults() const;
  /// Returns the present parameters of a component of this process, also while one of its callbacks runs. Errors: it is
  /// not loaded here.
  [[nodiscard]] Result<std::vector<ParameterReport>, Problem> parameters_of(std::uint64_t id) const;
  /// Returns the request that loaded a component, with its parameters as they are now; nothing for an unknown id.
  [[nodiscard]] std::optional<LoadRequest> request_of(std::uint64_t id) const;
  /// Describes what components of this process share other than streams and services, and could not share with another
  /// process.
  [[nodiscard]] std::vector<std::string> ties() const;
  [[nodiscard]] std::vector<ComponentInfo> list() const;
  /// Returns the libraries that are mapped although no component uses them, after closing those that have become free.
  [[nodiscard]] std::vector<KeptImage> kept_images();
  /// Returns how many components were abandoned because their code did not return. Their threads keep running, so the
  /// process must end with _exit(), without running destructors.
  [[nodiscard]] std::size_t abandoned() const;
  /// For ContainerOptions::run_by_caller: runs what is ready, and the timers, deadlines and leases that are due, until nothing is. Returns
  /// when the next one is due. Threads: one, also for load(), unload() and trigger() then.
  MonotonicTime step();
  /// Returns which of the container's own threads has made no progress since the last call (the supervisor, or an executor with
  /// something to run); empty: none. A component that hangs is none of them, as long as the others run. Call it at
  /// intervals of a second or more. Threads: one.
  [[nodiscard]] std::string stalled();
  /// Sets a function that a thread calls at least every 100 ms while it waits for a component in load(), unload() or trigger().
  /// Call it while no thread does.
  void call_while_waiting(std::function<void()> hook);
  /// Calls that function. For components of another process.
  void note_waiting() const;
  /// Finds a component by id ("3"), fully qualified name, or name without namespace if only one has it.
  [[nodiscard]] Result<ComponentInfo, Problem> find(const std::string& name_or_id) const;

  [[nodiscard]] TransitionOutcome trigger(std::uint64_t id, Transition transition);
  /// Replaces ContainerOptions::transition_timeout from now on. A shutdown sets a shorter one.
  void give_up_transitions_after(Duration limit);
  /// Returns whether a node offers a service of that name, of any type, and can answer.
  [[nodiscard]] bool service_is_ready(const std::string& name) const;

  /// Sends a request, whose fields are moved out. Calls `on_answer` when the call no longer waits, on a thread of the
  /// server with locks held, so it may only set a flag. Errors: no node here offers the service, or not with that type,
  /// or it is not active.
  [[nodiscard]] Result<std::unique_ptr<ServiceCall>, Problem> call_service(const std::string& name,
                                                                           const msgs::ServiceType& type, void* request,
                                                                           std::function<void()> on_answer);
  /// Returns the services of this process with their servers and clients, also those of the container's own node.
  [[nodiscard]] std::vector<ServiceReport> services() const;
  /// Returns the endpoints that belong to nodes, by topic, without those of tools.
  [[nodiscard]] std::vector<EndpointReport> endpoints() const;

  /// Returns the pairs with incompatible QoS. A pair is known once its second endpoint is declared.
  [[nodiscard]] std::vector<ClashReport> clashes() const;
  /// Returns the frames with two parents or two owners: both of them, and what makes each broadcast the frame.
  [[nodiscard]] std::vector<Problem> frame_conflicts() const;
  /// Returns every claimed transform, in the order of the claims.
  [[nodiscard]] std::vector<ClaimedFrame> frames() const;
  /// Returns how a topic is wired. WiringReport::late counts messages older than `age` (within the histogram's 12.5 %).
  [[nodiscard]] WiringReport wiring(const std::string& topic, Duration age) const;
  /// Returns the topics that a node publishes.
  [[nodiscard]] std::vector<std::string> topics_of(const std::string& node) const;
  /// Replaces the contents of the vector and keeps its memory. A repeated call allocates nothing while the graph does
  /// not change. The same holds for the other reports.
  void report_streams(std::vector<StreamReport>& out) const;
  void report_readers(std::vector<ReaderReport>& out) const;
  void report_histograms(std::vector<HistogramReport>& out) const;
  void report_callbacks(std::vector<CallbackReport>& out) const;
  void report_threads(std::vector<ThreadReport>& out) const;
  void report_loads(std::vector<LoadReport>& out) const;
  /// Returns the type of a topic, or null. Type objects live in message libraries.
  [[nodiscard]] const msgs::MessageType* topic_type(const std::string& topic) const;
  /// Returns the object that nodes get from Node::shared_object(), or null if no node has created it.
  [[nodiscard]] std::shared_ptr<void> shared_object(const std::string& name) const;

  /// Increments MotionStops and writes every registered stop frame, without running component code, also in other
  /// processes. A node that watches the count keeps its actuators stopped until it is activated again. Threads: any,
  /// but not from a signal handler.
  void write_safe_stops() const;
  /// Makes every component that moves something ignore commands from now on, and writes its stop frame, also in other
  /// processes. Does not block. Threads: any, but not from a signal handler.
  void stop_what_moves() const;

  /// Sets the callback for a component that became faulted. It runs on a thread of the container; keep it short, and
  /// load or unload nothing. Here and below, the calls of a callback do not overlap, and there are none after it was
  /// replaced. tell_fault() and tell_state() are exceptions: they call on their caller's thread, without this
  /// guarantee.
  void on_fault(std::function<void(const ComponentInfo&)> callback);
  /// Sets the callback for an open fault that begins, or is over (`lasted`). It runs on the reporting thread; keep it
  /// short.
  void on_open_fault(std::function<void(const FaultEvent&)> callback);
  /// Sets the callback for each state that a node enters. It runs on the thread of the transition; keep it short, and
  /// call nothing of the container.
  void on_state(std::function<void(const StateChange&)> callback);
  /// Sets the callback after any load, unload, transition or parameter change. Keep it short, and call nothing of the
  /// container.
  void on_change(std::function<void()> callback);

 private:
  friend class NodeServices;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle::runtime
