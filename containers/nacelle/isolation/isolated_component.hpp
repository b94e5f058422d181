// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "loading/program_places.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/foreign_component.hpp"
#include "nacelle/transport_local/link.hpp"
#include "process/foreign_programs.hpp"

namespace nacelle::isolation {

/// A launch file's component with `isolate: process`. It runs alone in a process of this program. A link over one
/// socket connects its streams to the container's graph and carries its lifecycle requests.
///
/// If the process ends unexpectedly, the component is faulted with the reason and its streams disappear.
/// Threads: start(), unload() and the destructor from one thread at a time; info() and trigger() from any.
class IsolatedComponent final : public runtime::ForeignComponent {
 public:
  /// Starts the process and loads the component. If `faults` is given, it collects the invalid parameter values.
  /// Errors: as Container::load(); a process that does not start; a component with ties to its own process (transforms
  /// it claims, objects it shares).
  [[nodiscard]] static Result<std::shared_ptr<IsolatedComponent>, Problem> start(const launch::ComponentPlan& plan,
                                                                                 const loading::ProgramPlaces& places,
                                                                                 runtime::Container& container,
                                                                                 Carrier* carrier, const Clock& clock,
                                                                                 ParameterFaults* faults = nullptr);
  IsolatedComponent(const launch::ComponentPlan& plan, const loading::ProgramPlaces& places,
                    runtime::Container& container, Carrier* carrier, const Clock& clock);
  ~IsolatedComponent() override;

  runtime::ComponentInfo info() const override;
  runtime::LoadRequest request() const override;
  TransitionOutcome trigger(Transition transition) override;
  void stop_what_moves() override;
  void give_up_transitions_after(Duration limit) override;
  runtime::UnloadOutcome unload() override;

 private:
  [[nodiscard]] Result<void, Problem> spawn();
  [[nodiscard]] Result<nlohmann::json, Problem> call(nlohmann::json request);
  void tell(const nlohmann::json& order);
  void on_note(const std::string& note);
  void on_end(const Problem& problem);
  void on_open_fault(const nlohmann::json& told);
  void tell_fault(const runtime::ComponentInfo& faulted, const std::string& callback);
  void end_process();
  [[nodiscard]] bool is_closing() const;

  const launch::ComponentPlan plan_;
  const loading::ProgramPlaces& places_;
  runtime::Container& container_;
  Carrier* const carrier_;  // outlives this object; may be null
  const Clock& clock_;
  Duration limit_ NACELLE_GUARDED_BY(mutex_);              // of a transition
  MonotonicTime limited_at_ NACELLE_GUARDED_BY(mutex_){};  // when limit_ was set last
  msgs::TypeLibrary types_;                                // used by the link's thread

  Mutex calling_;  // one request at a time
  mutable Mutex mutex_;
  std::condition_variable answered_;
  runtime::ComponentInfo info_ NACELLE_GUARDED_BY(mutex_);
  runtime::LoadRequest request_ NACELLE_GUARDED_BY(mutex_);
  std::uint64_t next_call_ NACELLE_GUARDED_BY(mutex_) = 1;
  std::unique_ptr<nlohmann::json> answer_ NACELLE_GUARDED_BY(mutex_);
  bool gone_ NACELLE_GUARDED_BY(mutex_) = false, closing_ NACELLE_GUARDED_BY(mutex_) = false;
  std::int32_t process_ NACELLE_GUARDED_BY(mutex_) = 0;  // its id; 0 after its end
  std::string how_ NACELLE_GUARDED_BY(mutex_);           // how the process ended

  Mutex process_mutex_;
  std::unique_ptr<process::ForeignProgram> program_ NACELLE_GUARDED_BY(process_mutex_);
  std::unique_ptr<Link> link_;
};

}  // namespace nacelle::isolation
