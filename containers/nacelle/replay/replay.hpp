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
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"
#include "proof/proof.hpp"
#include "record/model/ordered_messages.hpp"
#include "replay/cast.hpp"
#include "replay/recorded_inputs.hpp"
#include "replay/replay_output.hpp"
#include "replay/told_clock.hpp"

namespace nacelle::replay {

/// What a replay has done.
struct ReplayFigures {
  InputFigures inputs;
  std::map<std::string, std::uint64_t> outputs;  ///< Messages of running components, by topic.
  double seconds = 0.0;                          ///< Of the recording.
};

/// Returns the components of a plan as their constructors declare them. No device is opened.
[[nodiscard]] std::vector<Candidate> candidates_of(const proof::InertRobot& inert);

/// Components of a launch file that run on a recording: one thread, and a clock that is told the recorded times.
///
/// The clock goes to the next recorded message or the next timer, whichever is earlier (a timer first, if both are due), and everything
/// that has become ready runs before the clock goes on. So a run depends on the recording, the plan and the components only.
/// What a component does on a thread of its own is not part of that; drivers, which have one, are not replayed.
/// Threads: one.
class Replay {
 public:
  struct Options {
    std::vector<std::string> component_folders;
    RecordedInputs::FindType find_type;
    record::Compression compression = record::Compression::None;
    bool writes_inputs = false;  ///< Write what is played, too.
  };
  /// Components with a role run. The recording, the plan and the sink outlive it.
  Replay(record::OrderedMessages& recording, const launch::Plan& plan, const std::vector<Role>& roles,
         record::ByteSink& sink, Options options);
  ~Replay();
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  /// Loads, configures and activates the components at the time of the recording's first message. Returns the problems of components that are
  /// not required, which do not run. Errors: a component that is required fails.
  [[nodiscard]] Result<std::vector<Problem>, Problem> bring_up();
  /// Returns the recorded topics that cannot be played, each with the reason; after bring_up().
  [[nodiscard]] const std::vector<std::string>& refused() const { return inputs_->refused(); }
  /// Replays the whole recording. Calls `goes_on` now and then, with the part that is done, 0 to 1; ends early when that says false.
  /// Returns false if not everything could be written.
  [[nodiscard]] bool run(const std::function<bool(double)>& goes_on);

  [[nodiscard]] ReplayFigures figures() const;
  /// Returns the faults of components, in their order.
  [[nodiscard]] std::vector<runtime::FaultEvent> faults() const { return container_->faults(); }

 private:
  [[nodiscard]] Result<void, Problem> load(std::vector<Problem>& left_out);
  [[nodiscard]] Result<void, Problem> trigger(Transition transition, std::vector<Problem>& left_out);
  void write_new_topics();
  void run_until(WallTime time);
  void make_inputs();

  record::OrderedMessages& recording_;
  const launch::Plan& plan_;
  const std::vector<Role> roles_;
  const Options options_;
  ToldClock clock_;
  std::unique_ptr<runtime::Container> container_;
  struct Member {
    const launch::ComponentPlan* plan = nullptr;
    std::uint64_t id = 0;
  };
  std::vector<Member> members_;  // in the order of bring-up
  std::optional<RecordedInputs> inputs_;
  ReplayOutput output_;
};

}  // namespace nacelle::replay
