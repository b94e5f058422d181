// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <nacelle_interfaces/srv/get_faults.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "answers/robot.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"
#include "session/composition.hpp"
#include "session/early_crashes.hpp"
#include "session/fault_topics.hpp"
#include "session/restarts.hpp"

namespace nacelle::session {

/// What Supervision needs in addition to the robot. All of it must outlive the Supervision.
struct SupervisedRun {
  answers::Robot& robot;
  const Clock& clock;
  Bell& bell;  ///< Wakes the main thread for work().
  std::function<void(const std::string& line)> say;
  const std::vector<ComposedComponent>& left_out;  ///< Left out because they crashed repeatedly.
  EarlyCrashes& crashes;
};

/// Handles a component's fault: its policy, the topics that report it, and the answer to `nacelle faults` (design D7).
///
/// Before this class is notified, the container has done what is urgent: for stop_robot, it has written the stop
/// frames.
/// Threads: the main thread, except report(). The container's hooks only record the event and wake the main thread.
class Supervision {
 public:
  explicit Supervision(SupervisedRun run);
  ~Supervision();
  Supervision(const Supervision&) = delete;
  Supervision& operator=(const Supervision&) = delete;

  /// Publishes events and executes due restarts and stops.
  void work();
  /// Publishes events without handling faults, for bring-up and shutdown, during which nothing is restarted.
  void publish();
  /// Returns when work() must run even without an event.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const;
  /// Returns whether a fault has stopped the robot; the run ends with a failure then.
  [[nodiscard]] bool has_stopped_the_robot() const { return !known_.lock()->stopped_by.empty(); }
  /// Returns the text of a fault with the policy restart_container, for which the process ends and keeps its state; empty: none.
  [[nodiscard]] const std::string& why_to_restart() const { return why_to_restart_; }
  /// Returns the state that a pending restart leads to, for the composition. Returns nothing if no restart is pending;
  /// the component's own state counts then.
  [[nodiscard]] std::optional<launch::TargetState> target_of_restart(const std::string& node) const;
  /// Returns the text of a fault with the policy stop_robot or restart_container that work() has not handled yet, which ends the bring-up;
  /// empty: none.
  [[nodiscard]] std::string why_to_stop();
  /// Returns whether the component has registered a stop frame in this run or in the resumed run.
  [[nodiscard]] bool was_actuator(const std::string& node) const { return actuators_.count(node) != 0; }
  void note_actuator(const std::string& node) { actuators_.insert(node); }
  /// Sets the fault of the container itself; an empty code clears it.
  void set_own_fault(const FaultReason& fault);
  /// Returns the faults and how they are handled, without the crash of an earlier run. Threads: any.
  [[nodiscard]] nacelle_interfaces::srv::GetFaults::Response report() const;

 private:
  struct Noted {
    std::vector<runtime::ComponentInfo> faults;
    std::vector<runtime::StateChange> states;
  };
  struct Patient {  // how to restart a component
    runtime::LoadRequest request;
    bool isolated = false;  // in a process of its own; loaded as the plan requires
    bool gone = false;      // the last restart could not load it
    launch::TargetState target = launch::TargetState::Active;
    FaultHandling handling;
  };
  [[nodiscard]] FaultHandling handling_of(const runtime::ComponentInfo& info) const;
  [[nodiscard]] bool stops_the_robot(const runtime::ComponentInfo& info) const;
  [[nodiscard]] Noted take_noted();
  void publish(const Noted& noted);
  void on_fault(const runtime::ComponentInfo& info);
  void plan_restart(const std::string& node, const Patient& patient);
  void restart(const std::string& node);
  [[nodiscard]] Result<runtime::ComponentInfo, Problem> load_again(const std::string& node, const Patient& patient);
  void stop_robot(const runtime::ComponentInfo& cause);
  /// Returns the state in which a faulted component was, or to which it was going.
  [[nodiscard]] launch::TargetState target_before(const runtime::ComponentInfo& faulted) const;
  /// Returns the components that were left out and are not loaded now.
  [[nodiscard]] std::vector<FaultTopics::Absent> absent(const std::vector<runtime::ComponentInfo>& components) const;
  /// Resets the crash counts of components that have run for EarlyCrashes::kEarly.
  void forget_old_crashes(const std::vector<runtime::ComponentInfo>& components);

  struct Known {  // for report()
    Restarts restarts;
    FaultReason own_fault;   // of the container itself
    std::string stopped_by;  // the node whose fault stopped the robot
    std::vector<FaultTopics::Absent> absent;
  };

  runtime::Container& container() const { return run_.robot.container(); }

  const SupervisedRun run_;
  std::string why_to_restart_;
  Guarded<Noted> noted_;
  Guarded<Known> known_;
  FaultTopics topics_;
  std::map<std::string, Patient> patients_;
  std::map<std::string, launch::TargetState> before_fault_;  // the state of a node before its error processing
  std::vector<std::string> active_order_;                    // nodes in the order in which they became active
  std::set<std::string> actuators_;
  std::map<std::string, MonotonicTime> up_since_;  // of components whose crashes are counted
  std::optional<MonotonicTime> next_beat_;         // next publication of diagnostics, while a component is faulted
};

}  // namespace nacelle::session
