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

/// What is offered in the name of each component's node, as rclcpp's nodes do (docs/node_interfaces.md).
enum class NodeInterfaces : std::uint8_t {
  None,
  Topics,  ///< /rosout and /parameter_events: of a process whose services nobody else reaches.
  All,     ///< The services of parameters, lifecycle and types too.
};

struct ContainerOptions {
  std::string name = "nacelle";
  std::string name_space = "/";             ///< Of the container's own node.
  std::vector<std::string> component_path;  ///< Folders with plugin libraries and their index/.
  Duration handover_after = 20ms;           ///< A callback longer than this loses its executor to a spare thread.
  Duration hang_after = 1500ms;             ///< A callback longer than this faults its component.
  Duration transition_timeout = 30s;  ///< A lifecycle callback, constructor or destructor longer than this is given up.
  NodeInterfaces node_interfaces = NodeInterfaces::None;
};

class CompositionHost;
class ForeignComponent;

/// Loads components, runs them, takes them out again; one per process.
///
/// Code of a component runs on its executor or on a thread of its own, never on the caller's and never under a lock: one that takes
/// its time, or never returns, delays whoever called for it and nobody else.
/// The node /<options.name> offers services of composition_interfaces and nacelle_interfaces below ~/_container to every component.
/// Threads: everything from any thread. load(), unload() and trigger() wait for the component, at most for transition_timeout;
///          the others keep running meanwhile. From a callback that would wait for itself, unload() and trigger() say so instead.
class Container final {
 public:
  Container(ContainerOptions options, const Clock& clock);
  ~Container();
  Container(const Container&) = delete;
  Container& operator=(const Container&) = delete;

  [[nodiscard]] const ContainerOptions& options() const;
  /// The full name of the container's own node.
  [[nodiscard]] std::string node() const;
  [[nodiscard]] const Clock& clock() const;
  /// The in-process transport, for readers and writers that are not components (the control socket's).
  [[nodiscard]] Transport& transport();
  /// The same, for links to other processes.
  [[nodiscard]] Graph& graph();
  [[nodiscard]] ServiceGraph& service_graph();

  /// Errors: what is wrong with plugin, library or parameters; a name that is taken; a constructor that threw, or has not
  /// returned in time (then the image is kept, and what the constructor makes later is destroyed at once).
  [[nodiscard]] Result<ComponentInfo, Problem> load(const LoadRequest& request);
  /// The instance ends at once, the image as soon as nobody holds it (UnloadOutcome, kept_images()).
  [[nodiscard]] Result<UnloadOutcome, Problem> unload(std::uint64_t id);
  /// Takes in a component of another process: listed, found, triggered and unloaded as the others. Errors: its name is taken.
  [[nodiscard]] Result<ComponentInfo, Problem> adopt(std::shared_ptr<ForeignComponent> component);
  /// Lets `host` carry out what the services of the container's node are asked to load and unload, instead of load() and unload();
  /// null: these again. Waits for the call that is being answered, so the host must not hold it up any more. `host` outlives its use.
  void compose_through(CompositionHost* host);
  /// Offers a service below ~/_container of the container's own node until the handle ends. Its callbacks run one at a time on the thread
  /// of the nodes' standard services (docs/node_interfaces.md): they must return soon and wait for no component.
  [[nodiscard]] std::unique_ptr<ServiceHandle> offer_service(const std::string& name, const msgs::MessageType& request,
                                                             const msgs::MessageType& response,
                                                             ServiceCallback callback);
  /// A component of another process has become faulted.
  void tell_fault(const ComponentInfo& info, const std::string& callback = {});
  /// An open fault of a component of another process has begun, or is over (`lasted`).
  void tell_open_fault(const FaultEvent& event);
  /// A component of another process has entered a state: told as those of this process are.
  void tell_state(const StateChange& change);
  /// The last faults of each node, in their order; those of components that are gone too.
  [[nodiscard]] std::vector<FaultEvent> faults() const;
  /// What a component was loaded with, its parameters as they were set since; nothing for one of another process.
  [[nodiscard]] std::optional<LoadRequest> request_of(std::uint64_t id) const;
  /// What components here have in common beside streams and services, and could not have with another process, in words.
  [[nodiscard]] std::vector<std::string> ties() const;
  [[nodiscard]] std::vector<ComponentInfo> list() const;
  /// Libraries that are still mapped for nobody's use. Closes those that have become free.
  [[nodiscard]] std::vector<KeptImage> kept_images();
  /// How many components were given up while their code had not returned. Their threads live on, with all that they use: a
  /// process that ends beside them must not run its destructors at exit (_exit()).
  [[nodiscard]] std::size_t abandoned() const;
  /// By id ("3"), fully qualified name, or name without namespace if it is the only one.
  [[nodiscard]] Result<ComponentInfo, Problem> find(const std::string& name_or_id) const;

  [[nodiscard]] TransitionOutcome trigger(std::uint64_t id, Transition transition);
  /// From now on instead of ContainerOptions::transition_timeout: a shutdown waits for nobody that long.
  void give_up_transitions_after(Duration limit);
  /// Whether a node offers a service of that name, whatever its type, and can answer.
  [[nodiscard]] bool service_is_ready(const std::string& name) const;

  /// Sends a request, whose fields are moved out, and tells `on_answer` when the call is not waiting any more: on a thread of the
  /// server with locks held, so only note it. Errors: no node here offers the service, or not with that type, or it is not active.
  [[nodiscard]] Result<std::unique_ptr<ServiceCall>, Problem> call_service(const std::string& name,
                                                                           const msgs::ServiceType& type, void* request,
                                                                           std::function<void()> on_answer);
  /// The services of this process: who offers and who calls them. Those of the container's own node too.
  [[nodiscard]] std::vector<ServiceReport> services() const;
  /// The ends of streams that belong to nodes, by topic; those of tools are left out.
  [[nodiscard]] std::vector<EndpointReport> endpoints() const;

  /// Pairs that do not match, known since their second end was declared.
  [[nodiscard]] std::vector<ClashReport> clashes() const;
  /// Frames with two parents or two owners: both, and what makes each of them broadcast it.
  [[nodiscard]] std::vector<Problem> frame_conflicts() const;
  /// Every transform that somebody has claimed, in the order of the claims.
  [[nodiscard]] std::vector<ClaimedFrame> frames() const;
  /// How a topic is wired. `age` is what `late` counts from (within the histogram's 12.5 %).
  [[nodiscard]] WiringReport wiring(const std::string& topic, Duration age) const;
  /// The topics that a node publishes.
  [[nodiscard]] std::vector<std::string> topics_of(const std::string& node) const;
  /// Fills the vectors anew, keeping their memory: asking again allocates nothing while the graph stays as it is.
  void report_streams(std::vector<StreamReport>& out) const;
  void report_readers(std::vector<ReaderReport>& out) const;
  void report_histograms(std::vector<HistogramReport>& out) const;
  void report_callbacks(std::vector<CallbackReport>& out) const;
  void report_threads(std::vector<ThreadReport>& out) const;
  void report_loads(std::vector<LoadReport>& out) const;
  /// The type of a topic, or null. Type objects live in message libraries.
  [[nodiscard]] const msgs::MessageType* topic_type(const std::string& topic) const;
  /// The same object that nodes get from Node::shared_object(), or null if nobody has made it.
  [[nodiscard]] std::shared_ptr<void> shared_object(const std::string& name) const;

  /// Counts one of MotionStops and writes every registered stop frame, without running component code: what heeds the count stands
  /// still until it is activated anew. Those of other processes too. Threads: any, but not from a signal handler.
  void write_safe_stops() const;
  /// What moves something hears no commands from now on, and its stop frame is written; those of other processes too. Waits for
  /// nobody. Threads: any, but not from a signal handler.
  void stop_what_moves() const;

  /// Called with a component that became faulted, on a thread of the container; keep it short, and load or unload nothing.
  /// As with those below, one call at a time, and none after it was replaced.
  void on_fault(std::function<void(const ComponentInfo&)> callback);
  /// Called when an open fault begins and when it is over (`lasted`), on the thread that said so; keep it short.
  void on_open_fault(std::function<void(const FaultEvent&)> callback);
  /// Called with each state that a node enters, on the thread of its transition; keep it short, and call nothing here.
  void on_state(std::function<void(const StateChange&)> callback);
  /// Called after a load, an unload, a transition or a set parameter of whoever; keep it short, and call nothing here.
  void on_change(std::function<void()> callback);

 private:
  friend class NodeServices;  // asks what no other asks
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle::runtime
