// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/graph.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/node/service_graph.hpp"
#include "nacelle/runtime/introspection.hpp"

namespace nacelle::runtime {

/// Which thread runs a component's callbacks.
struct ThreadPolicy {
  bool own = false;           ///< false: the container's shared executor, which has one thread.
  int priority = 0;           ///< 1 to 99 asks for SCHED_FIFO; refused with a warning where not allowed.
  std::vector<int> cpus;      ///< Empty: any.
  std::uint32_t threads = 1;  ///< Of one's own: more than one lets callback groups run at the same time.
};

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

/// What follows when a component is faulted.
enum class FaultPolicy : std::uint8_t {
  Degrade,  ///< It stays faulted, the others go on.
  Restart,  ///< It is loaded anew and taken to where it was, after a pause, so many times; then it is left to degrade.
  StopRobot,  ///< Every registered stop frame is written at once, then all components are deactivated.
};
[[nodiscard]] const char* words_of(FaultPolicy policy);  ///< "degrade", "restart", "stop_robot"
struct FaultHandling {
  std::optional<FaultPolicy>
      policy{};                    ///< None: StopRobot for a component that moves something, Degrade for the others.
  std::uint32_t max_restarts = 3;  ///< In a row: one that was active for a minute begins anew.
  Duration backoff = 1s;           ///< Before each restart.
  [[nodiscard]] FaultPolicy policy_for(bool actuator) const {
    return policy.value_or(actuator ? FaultPolicy::StopRobot : FaultPolicy::Degrade);
  }
  friend bool operator==(const FaultHandling&, const FaultHandling&) = default;
};

/// A transform that a node broadcasts, or would while nobody else does.
struct ClaimedFrame {
  std::string node, parent, child;
  FrameClaimKind kind = FrameClaimKind::Primary;
  Place origin;       ///< What one changes if it should not: the parameter publish_tf.
  bool owns = false;  ///< Of frames()'s answer only: of all that claim the child, this one broadcasts it.
};

/// What a component's constructor has said of it, beside its endpoints and transforms.
struct Declarations {
  struct Value {
    std::string name;
    ParameterValue value;
    bool given = false;  ///< By the composition; else the default.
  };
  std::vector<Value> parameters;
  std::vector<std::string> unknown_parameters;  ///< Given, and nobody's.
  std::vector<FrameUse> frame_uses;
  std::vector<DeviceUse> device_uses;
  std::vector<std::string> services;  ///< Full names of those that it offers.
  std::vector<bool> used_remaps;      ///< By the place in LoadRequest::remaps: the rule changed a name.
  std::string package;                ///< That registers the class.
};

/// What is to be made of a plugin.
struct LoadRequest {
  std::string plugin;            ///< "nacelle::lidar::LidarComponent"
  std::string name, name_space;  ///< Empty: the component's own name, "/".
  std::map<std::string, ParameterValue> parameters;
  std::vector<RemapRule> remaps;
  std::vector<QosOverride> qos;
  ThreadPolicy thread;
  FaultHandling on_fault{};
  /// Refused values are collected here, and the component is made with the defaults instead. Null: the first fails the load.
  std::shared_ptr<ParameterFaults> faults{};
};

struct ComponentInfo {
  std::uint64_t id = 0;  ///< Starts at 1, never reused.
  std::string node;      ///< "/lidar"
  std::string plugin, library;
  StateId state = StateId::Unknown;  ///< Unknown for a plain Node.
  bool managed = true;               ///< A LifecycleNode.
  FaultReason fault;                 ///< Why it is faulted; empty code when it is not.
  /// Of load()'s answer only: parameters that were given and that the component does not have.
  std::vector<std::string> warnings{};
  bool actuator = false;                           ///< It has registered a stop frame: it moves something.
  std::shared_ptr<const Declarations> declared{};  ///< Of load()'s answer only.
  std::int32_t process = 0;                        ///< The number of its own process; 0: this one, or it has ended.
  std::vector<FaultReason>
      open_faults{};  ///< What it mends itself; it stays in its state meanwhile, and `fault` is empty.
};

/// A component became faulted, or had an open fault.
struct FaultEvent {
  std::uint64_t number = 0;  ///< Of the container, from 1.
  std::string node, code, text;
  std::string callback;  ///< What it happened in: "subscription /scan", "transition on_configure", "thread lidar_rx".
  WallTime when;
  bool is_open_fault = false;        ///< LifecycleNode::open_fault(): the component stays as it is.
  std::optional<Duration> lasted{};  ///< Of an open fault that is over.
};

/// A node entered a state; a transition makes two or three of these.
struct StateChange {
  std::string node;
  StateId from = StateId::Unknown, to = StateId::Unknown;
  WallTime when;
};

/// What became of a component that was taken out.
struct UnloadOutcome {
  bool image_closed = false;  ///< The library is out of the address space.
  std::string held_by;        ///< Why not: "2 messages of /camera/image_raw", "another instance (3)".
};

/// "Image kept, held by X": the component is gone, or never came to be, and its library is still mapped.
struct KeptImage {
  std::string node;             ///< "/camera"; the plugin's name if its constructor has not got as far as a node.
  std::string plugin, library;  ///< As in ComponentInfo.
  std::string
      held_by;  ///< "2 messages of /camera/image_raw", "its constructor, which has not returned", "the process (...)"
};

/// How messages came from publish() to their callbacks; a latency means little without it. Two bits.
enum class HandedOver : std::uint8_t { Never = 0, Inline = 1, AcrossThreads = 2, Both = 3 };
/// "inline" (on one thread), "across threads", "both", or "" for never.
[[nodiscard]] const char* words_of(HandedOver way);

/// One stream of the report.
struct StreamReport {
  std::string name, type;
  std::uint64_t published = 0, delivered = 0;
  std::size_t writers = 0, readers = 0;
  MonotonicTime first, last;  ///< First and last publish().
  std::uint64_t overwritten = 0, full = 0, inactive = 0, expired = 0, discarded = 0, would_block = 0, rehomed = 0;
  std::uint64_t inactive_unpublished = 0;  ///< Messages that a not active writer dropped.
  std::uint64_t pool_dry = 0;              ///< Messages that a writer dropped since its pool was dry.
  std::uint64_t pool_grown = 0;            ///< Messages that the writers' pools have made.
  std::uint64_t copies = 0, bytes_copied = 0;
  std::uint64_t deadline_missed = 0;                     ///< Periods in which a writer broke the deadline it offers.
  Duration latency_p50{}, latency_p99{}, latency_max{};  ///< publish() to callback start ...
  HandedOver handed_over = HandedOver::Never;            ///< ... this way.
  /// Messages per second between the first and the last publish(); 0 for fewer than two.
  [[nodiscard]] double hz() const;
};

/// One reader of a stream, with what waits for it.
struct ReaderReport {
  std::string topic, type, node;
  bool other_process = false;  ///< A stand-in: it stands in a process of its own.
  bool open = true;            ///< The lifecycle gate.
  bool keeps_all = false;
  std::size_t waiting = 0;  ///< Messages in its queue now ...
  std::size_t depth = 0;    ///< ... and how many it takes at most.
  std::uint64_t delivered = 0, overwritten = 0, full = 0, inactive = 0, expired = 0, discarded = 0;
  std::uint64_t deadline_missed = 0;  ///< Periods without a message, of the deadline that it asks for.
  Duration latency_p50{}, latency_p99{}, latency_max{};  ///< publish() to callback start.
};

struct HistogramReport {
  std::string node, name;
  std::uint64_t count = 0;
  Duration p50{}, p99{}, max{};
};

/// One callback of a component.
struct CallbackReport {
  std::string node;  ///< "/lidar"
  std::string kind;  ///< "subscription", "timer", "service" or "client"
  std::string name;  ///< The topic or service; a timer's period.
  std::uint64_t count = 0;
  std::uint64_t skipped = 0;                                ///< Ticks that did not run because an earlier one was late.
  Duration duration_p50{}, duration_p99{}, duration_max{};  ///< Start to return.
  Duration duration_total{};                                ///< Within 6.25 %.
  /// Until the start: from publish(), from the moment at which the timer was due, from the arrival of the call.
  Duration latency_p50{}, latency_p99{}, latency_max{};
};

/// One thread of an executor.
struct ThreadReport {
  std::string executor;        ///< "executor" is the shared one.
  std::int32_t thread_id = 0;  ///< As in /proc/self/task.
  const char* state = "";      ///< "serving", "late" (its callback overstays) or "spare"
  Duration cpu{};              ///< Since it was started.
};

/// What a component costs. Reading a thread's CPU clock is a system call: about one callback in 128 is measured.
struct LoadReport {
  std::string node;
  std::uint64_t callbacks = 0;  ///< That ran.
  std::uint64_t samples = 0;    ///< Of them, measured.
  Duration cpu{};               ///< Estimate: the mean of the samples times the callbacks.
  std::string executor;         ///< That runs them; "executor" is the shared one.
  bool own_threads = false;     ///< Nobody else's callbacks run there ...
  Duration thread_cpu{};        ///< ... so this is what its threads have used, exactly; else zero.
};

/// A pair of endpoints on one topic that cannot talk, and what would mend it.
struct ClashReport {
  std::string topic, writer_node, reader_node, policy, offered, requested, change;
  std::size_t other_writers = 0;  ///< Publishers of the topic that do serve this subscription.
  [[nodiscard]] std::string text() const;
};

/// How a stream is wired now, and what that costs.
struct WiringReport {
  std::string topic;
  std::vector<std::string> writer_nodes;
  std::vector<std::string> owner_nodes;  ///< That take the message as their own (Loan, unique_ptr).
  std::vector<std::string>
      other_processes;       ///< Nodes of other processes that send it here or get it from here: a copy each.
  std::uint64_t copies = 0;  ///< Per message, in publish() and on links: of the writer that makes most.
  std::uint64_t late = 0;    ///< Messages so far that were older than asked for when a callback began.
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
