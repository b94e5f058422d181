// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "answers/robot.hpp"
#include "control/server.hpp"
#include "loading/program_places.hpp"
#include "nacelle/base/bell.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"
#include "nacelle/node/container_facts.hpp"
#include "nacelle/node/network_facts.hpp"
#include "nacelle/runtime/budget.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/transport_local/carrier.hpp"
#include "networking/network.hpp"
#include "process/event_loop.hpp"
#include "process/foreign_programs.hpp"
#include "process/service_manager.hpp"
#include "process/stop_signal.hpp"
#include "proof/proof.hpp"
#include "report/run_report.hpp"
#include "session/clock_watch.hpp"
#include "session/composition.hpp"
#include "session/early_crashes.hpp"
#include "session/emergency_stops.hpp"
#include "session/lookout.hpp"
#include "session/reload.hpp"
#include "session/robot_service.hpp"
#include "session/supervision.hpp"
#include "session/transition_log.hpp"
#include "session/watchdog.hpp"

namespace nacelle::requests {
class RequestServer;
}
namespace nacelle::answers {
class InterfaceServices;
class Loader;
}  // namespace nacelle::answers

namespace nacelle::session {

struct SessionOptions {
  std::string container_name;  ///< Of the control socket.
  loading::ProgramPlaces places;
  std::optional<std::int64_t> seed;        ///< For the report only.
  std::string report_file;                 ///< Empty: none.
  std::vector<std::string> last_messages;  ///< Topics whose last message the report includes.
  bool verbose = false;                    ///< Prints a line for each step.
  /// The carrier for the streams of components with `isolate: process` (carriers.hpp). If it cannot start, or is empty,
  /// the links' sockets are used.
  std::string carrier;
  /// The file of the composition. The crash record is beside it, with `.crash` appended to its name. Empty:
  /// NAME.composition in the folder of the control socket, which is usually in RAM.
  std::string state_file;
  bool resume = false;           ///< Restore the components of the state file, if it exists, instead of the plan's.
  std::string transitions_file;  ///< Empty: none (transition_log.hpp).
  ClockAlarm* clock_alarm = nullptr;                         ///< Must outlive the session; null: the kernel's.
  const process::ServiceManager* service_manager = nullptr;  ///< Must outlive the session; null: none.
  std::vector<RunText> files;  ///< Those that were read for the plan; recordings have them.
  Reload::Reread reread;       ///< Reads the launch file again, for a reload; empty: there is none.
};

/// Writes the stop frames and kills the programs. StopSignal calls it at the third signal. Async-signal-safe.
void leave_at_once() noexcept;

/// Runs a launch file's plan as a robot: programs, components, order, control socket, orderly shutdown.
///
/// Threads: one, the main thread; it also serves the slow requests of the control socket.
class Session final : public answers::Robot {
 public:
  Session(launch::Plan plan, SessionOptions options, const Clock& clock, process::StopSignal& stop);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() override;

  /// Checks that the process may open enough files for a session. Call it before any file is opened.
  [[nodiscard]] static Result<void, Problem> check_descriptor_limit();
  /// Brings the robot up, runs it until a signal, a request or the end of a required program, and takes it down again.
  /// Returns the process's exit code; errors have been printed to stderr. Ends the process instead of returning if a
  /// thread still hangs in a component, or if a component closed descriptors of the container.
  [[nodiscard]] int run();
  /// Returns the problem for which run() returned an exit code other than 0, as it was printed. Returns nothing if a
  /// request, a signal or a component's fault ended the robot. A failed bring-up has a BringUpFault or a
  /// LifecycleFault.
  [[nodiscard]] const std::optional<Problem>& failure() const { return failure_; }

  // answers::Robot
  [[nodiscard]] const std::string& name() const override { return options_.container_name; }
  [[nodiscard]] answers::Phase phase() const override { return service_->phase(); }
  [[nodiscard]] runtime::Container& container() override { return *container_; }
  [[nodiscard]] const launch::Plan& plan() const override { return plan_; }
  [[nodiscard]] networking::Network& network() override { return *network_; }
  [[nodiscard]] const std::vector<std::filesystem::path>& message_folders() const override {
    return options_.places.message_folders;
  }
  [[nodiscard]] nacelle_interfaces::srv::GetFaults::Response faults() const override;
  [[nodiscard]] std::vector<std::string> emergency_stops() const override { return emergency_stops_->set(); }
  [[nodiscard]] Result<std::vector<answers::ReleasedStop>, Problem> release_emergency_stops(
      const std::vector<std::string>& topics) override {
    return emergency_stops_->release(topics);
  }
  using Robot::load;
  [[nodiscard]] Result<runtime::ComponentInfo, Problem> load(const launch::ComponentPlan& component,
                                                             const std::shared_ptr<ParameterFaults>& faults) override;
  /// Publishes the states, saves the composition, and restarts the measurement of the steady state.
  void composition_changed() override;
  void request_shutdown() override { stop_.raise_by_request(); }

 private:
  /// The time limit of each transition during shutdown.
  static constexpr Duration kShutdownStepLimit = std::chrono::seconds{3};

  /// Prints a line to stderr.
  void say(const std::string& line) const;
  /// Prints the problem, keeps it for failure(), and returns the exit code.
  int fail(Problem problem);
  [[nodiscard]] int run_robot();
  /// Runs the robot and reports an exception as a failure.
  [[nodiscard]] int guarded_run();
  [[nodiscard]] Result<void, Problem> guarded_bring_up();
  /// Does the work of the destructor, except closing what a hanging thread may still use.
  void end();
  /// Determines the path of the state file, and reads the composition to resume.
  [[nodiscard]] Result<void, Problem> look_at_state_file();
  /// Removes the components that repeatedly crashed early from the plan.
  void leave_out_what_crashes();
  /// Reports the components that move something and were restored as inactive.
  void say_what_rests() const;
  void keep_composition();
  [[nodiscard]] Result<void, Problem> set_held_stops();
  [[nodiscard]] Result<void, Problem> bring_up();
  [[nodiscard]] Result<void, Problem> start_programs();
  void start_the_carrier();
  [[nodiscard]] Result<void, Problem> load_components();
  /// Checks the plan and prints all findings. Errors: BringUpFault::UnsoundPlan, unless the run is resumed, which
  /// continues with what can be restored.
  [[nodiscard]] Result<void, Problem> check_the_plan();
  [[nodiscard]] Result<void, Problem> activate();
  /// Returns why the bring-up must end: a signal, or a fault with the policy stop_robot. It has stopped the actuators
  /// then. Empty: continue.
  [[nodiscard]] std::string why_not_go_up();
  [[nodiscard]] TransitionOutcome trigger(const std::string& node, Transition transition);
  void on_step(const lifecycle_manager::Step& step);
  void log_transition(const lifecycle_manager::Step& step);
  [[nodiscard]] process::Task services_task();
  [[nodiscard]] process::Task requests_task();
  void add_supervision(process::EventLoop& loop);
  void add_upkeep(process::EventLoop& loop);
  void add_programs(process::EventLoop& loop);
  void add_service_manager(process::EventLoop& loop);
  /// Sends a state to the service manager. `status` is what `systemctl status` shows.
  void tell_service_manager(const char* state, const std::string& status) const;
  [[nodiscard]] std::string running_status() const;
  /// Returns why the service manager is to restart the robot; empty: it is well.
  [[nodiscard]] std::string why_not_feed();
  void answer_guests();
  /// Reports when the process runs out of descriptors, and when some are available again.
  void look_at_descriptors();
  /// Reports programs that have ended. Returns the problem of the first one that is required, or nothing.
  [[nodiscard]] std::optional<Problem> look_at_programs();
  /// Runs the main loop. Returns the failure that ended it, or nothing.
  [[nodiscard]] std::optional<Problem> serve();
  void take_down();
  void take_final_figures();
  void fetch_last_messages();
  [[nodiscard]] bool write_report();

  void progress(const std::string& line) const;  // verbose: a line; terminal: a changing line; else nothing
  [[nodiscard]] std::shared_ptr<ContainerFacts> facts() const;
  [[nodiscard]] std::shared_ptr<NetworkFacts> network_facts() const;
  [[nodiscard]] const launch::ComponentPlan* plan_of(const std::string& node) const { return plan_.find(node); }

  launch::Plan plan_;
  SessionOptions options_;
  const Clock& clock_;
  process::StopSignal& stop_;
  bool on_terminal_;
  Bell fault_bell_;

  // end() destroys the servers first, so that no request arrives, and the container before the programs that it uses.
  std::vector<std::unique_ptr<process::ForeignProgram>> programs_;
  std::unique_ptr<Carrier> carrier_;
  std::unique_ptr<runtime::Container> container_;
  std::unique_ptr<networking::Network> network_;
  std::unique_ptr<Supervision> supervision_;
  std::unique_ptr<EmergencyStops> emergency_stops_;
  std::unique_ptr<RobotService> service_;
  std::unique_ptr<control::ControlServer> server_;
  std::unique_ptr<answers::Loader> loader_;
  std::unique_ptr<answers::InterfaceServices> answers_;
  std::unique_ptr<requests::RequestServer> request_server_;
  std::unique_ptr<lifecycle_manager::LifecycleManager> manager_;
  std::unique_ptr<TransitionLog> transitions_;
  runtime::BudgetWatch budgets_{{}};
  std::optional<MonotonicTime> next_budget_look_;  // none: no budget, or the robot is not running yet

  std::vector<proof::LoadedComponent> loaded_;  // until the plan is checked
  std::unique_ptr<CompositionFile> state_;
  std::unique_ptr<EarlyCrashes> crashes_;
  std::vector<ComposedComponent> left_out_;  // crashed repeatedly
  std::vector<std::string> resting_;         // restored as inactive, because they move something
  bool is_resumed_ = false;
  std::vector<std::string> held_actuators_;  // actuators of the resumed run
  std::vector<std::string> held_stops_;      // emergency stops that were set in it
  bool told_of_state_ = false;               // reported that the state file cannot be written
  std::atomic<bool> is_going_up_{true};      // the main thread is in bring_up()
  std::optional<Problem> failure_;
  bool undoing_ = false;              // the bring-up failed: there are no figures
  bool told_of_descriptors_ = false;  // reported that they ran out
  bool lost_descriptors_ = false;     // a component closed some of the container
  report::RunReport report_;
  std::string last_messages_json_;
  process::SteadyState steady_;
  std::optional<MonotonicTime> steady_from_;
  std::unique_ptr<Lookout> lookout_;  // until the shutdown begins
  const process::ServiceManager no_manager_;
  const process::ServiceManager& service_manager_;
  std::optional<Watchdog> watchdog_;
  std::optional<Reload> reload_;
};

}  // namespace nacelle::session
