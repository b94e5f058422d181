// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::runtime {

/// Which thread runs a component's callbacks.
struct ThreadPolicy {
  bool own = false;       ///< false: the container's shared executor.
  int priority = 0;       ///< 1 to 99 asks for SCHED_FIFO; refused with a warning where not allowed.
  std::vector<int> cpus;  ///< Empty: any.
};

struct ContainerOptions {
  std::string name = "nacelle";
  std::vector<std::string> component_path;  ///< Folders with plugin libraries and their index/.
  Duration handover_after = 20ms;           ///< A callback longer than this loses its executor to a spare thread.
  Duration hang_after = 1500ms;             ///< A callback longer than this faults its component.
  Duration transition_timeout = 30s;        ///< A lifecycle callback longer than this is given up.
};

/// What is to be made of a plugin.
struct LoadRequest {
  std::string plugin;            ///< "nacelle::lidar::LidarComponent"
  std::string name, name_space;  ///< Empty: the component's own name, "/".
  std::map<std::string, ParameterValue> parameters;
  std::vector<RemapRule> remaps;
  std::vector<QosOverride> qos;
  ThreadPolicy thread;
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
};

/// What became of a component that was taken out.
struct UnloadOutcome {
  bool image_closed = false;  ///< The library is out of the address space.
  std::string held_by;        ///< Why not: "2 messages of /camera/image_raw", "another instance (3)".
};

/// One stream of the report.
struct StreamReport {
  std::string name, type;
  std::uint64_t published = 0, delivered = 0;
  std::size_t writers = 0, readers = 0;
  MonotonicTime first, last;  ///< First and last publish().
  std::uint64_t overwritten = 0, full = 0, inactive = 0, discarded = 0, would_block = 0, rehomed = 0;
  std::uint64_t inactive_unpublished = 0;  ///< Messages that a not active writer dropped.
  std::uint64_t copies = 0, bytes_copied = 0;
  Duration latency_p50{}, latency_p99{}, latency_max{};  ///< publish() to callback start.
  /// Messages per second between the first and the last publish(); 0 for fewer than two.
  [[nodiscard]] double hz() const;
};

struct HistogramReport {
  std::string node, name;
  std::uint64_t count = 0;
  Duration p50{}, p99{}, max{};
};

/// A pair of endpoints on one topic that cannot talk, and what would mend it.
struct ClashReport {
  std::string topic, writer_node, reader_node, policy, offered, requested, change;
  [[nodiscard]] std::string text() const;
};

/// Loads components, runs them, takes them out again; one per process.
///
/// Threads: everything from any thread but from a component's callback. load(), unload() and trigger() wait for the component;
///          the others keep running meanwhile.
class Container final : public Context {
 public:
  Container(ContainerOptions options, const Clock& clock);
  ~Container() override;

  [[nodiscard]] const ContainerOptions& options() const;
  [[nodiscard]] const Clock& clock() const;
  /// The in-process transport, for readers and writers that are not components (the control socket's).
  [[nodiscard]] Transport& transport();

  [[nodiscard]] Result<ComponentInfo, Problem> load(const LoadRequest& request);
  [[nodiscard]] Result<UnloadOutcome, Problem> unload(std::uint64_t id);
  [[nodiscard]] std::vector<ComponentInfo> list() const;
  /// By id ("3"), fully qualified name, or name without namespace if it is the only one.
  [[nodiscard]] Result<ComponentInfo, Problem> find(const std::string& name_or_id) const;

  [[nodiscard]] TransitionOutcome trigger(std::uint64_t id, Transition transition);

  /// Pairs that do not match, known since their second end was declared.
  [[nodiscard]] std::vector<ClashReport> clashes() const;
  /// Frames that two nodes mean to broadcast.
  [[nodiscard]] std::vector<Problem> frame_conflicts() const;
  /// Fills the vectors anew, keeping their memory: asking again allocates nothing while the graph stays as it is.
  void report_streams(std::vector<StreamReport>& out) const;
  void report_histograms(std::vector<HistogramReport>& out) const;
  /// The type of a topic, or null. Type objects live in message libraries.
  [[nodiscard]] const msgs::MessageType* topic_type(const std::string& topic) const;
  /// The same object that nodes get from Node::shared_object(), or null if nobody has made it.
  [[nodiscard]] std::shared_ptr<void> shared_object(const std::string& name) const;

  /// Writes every registered stop frame, without running component code. Threads: any, but not from a signal handler.
  void write_safe_stops() const;

  /// Called with a component that became faulted, on a thread of the container; keep it short.
  void on_fault(std::function<void(const ComponentInfo&)> callback);

  [[nodiscard]] std::unique_ptr<NodeHost> create_host(const NodeIdentity& identity) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle::runtime
