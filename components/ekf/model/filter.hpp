// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ekf/model/assists.hpp"
#include "ekf/model/control.hpp"
#include "ekf/model/filter_observer.hpp"
#include "ekf/model/history.hpp"
#include "ekf/model/innovations.hpp"
#include "ekf/model/measurement_queue.hpp"
#include "ekf/model/preparation.hpp"
#include "ekf/model/process_model.hpp"
#include "ekf/model/statistics.hpp"

namespace nacelle::ekf {

struct FilterOptions {
  ProcessNoise process_noise;
  Belief initial;
  Duration sensor_timeout = 33ms;  ///< Without a measurement for this long the state is carried on to now.
  Duration period = 33ms;          ///< From one step() to the next.
  bool timeout_from_stamp =
      false;  ///< The silence counts from the filter's stamp, and nothing may wait; else from the last step that fused.
  bool two_d_mode = false;
  bool predict_to_current_time = false;
  bool dynamic_process_noise = false;
  std::size_t queue_limit = 4096;  ///< The most measurements that ever wait for a step.
  std::size_t parts = 0;           ///< How many parts of inputs there are; they are numbered from 0.
  ControlOptions control;          ///< Of no axis: commands are not used.
  InnovationOptions innovations;
  AssistOptions assists;  ///< All off: none of it runs.
  /// How far behind the filter a late measurement is put into its place; nothing: it corrects without going back.
  std::optional<Duration> history;
  std::int64_t replay_instructions = 1'500'000;  ///< Per step, about: what goes beyond waits for the next one.
  bool permit_corrected_publication = false;  ///< A late measurement makes output() give the filter's own stamp again.
  bool reset_on_time_jump = false;            ///< A clock that was set back by more than a second resets the filter.
};

/// Which time a measurement is processed. Only the first counts in any statistics.
enum class Pass : std::uint8_t {
  First,  ///< In its turn.
  Late,   ///< For the first time, but after others that are newer: the filter went back.
  Again,  ///< It was processed before; the filter went back for another one.
};

/// What going back has cost so far.
struct ReplayStats {
  std::uint64_t passes{};        ///< That ended: the belief is that of all measurements.
  std::uint64_t measurements{};  ///< Processed in them, late ones included.
  std::uint64_t continued{};     ///< Steps that left a pass to the next step.
};

/// The running filter: a belief, the measurements that wait, and what became of each.
///
/// Measurements are taken in the order of their stamps when step() comes. One that is older than the filter corrects it
/// without a prediction, as in robot_localization without smoothing; one from the future waits for its time.
///
/// With FilterOptions::history the filter goes back to the time of an older one and takes all that is newer again, as
/// robot_localization does with smoothing. Then the state is a function of the measurements, in whatever order they came: a prediction
/// without a measurement is undone by the next one. Going back costs no step more than FilterOptions::replay_instructions; until it has
/// ended, the belief is that without the late measurement. All that changes the belief for good is a measurement that goes through
/// process(); another change is undone by the next one.
///
/// A stamp is believed only as far as the inputs' rates explain it. With P the longer of a step and the shortest usual time
/// between two messages, 10 P (at most a second) is the longest that a stamp may lie ahead of the clock, and the most that the
/// state is carried beyond the time that has really passed. A stamp of zero is refused.
/// Threads: one. Allocates: in the constructor, and when more measurements wait than ever before.
class Filter {
 public:
  explicit Filter(const FilterOptions& options);

  /// Counts a part of a message that comes at `now`, and lets `prepare(Reading&) -> Prepared` fill it in, unless its stamp is
  /// too old to matter or cannot be right.
  template <typename F>
  void offer(std::uint16_t part, WallTime stamp, WallTime now, F&& prepare) {
    Measurement* const place = admit(part, stamp, now);
    if (place == nullptr) return;
    const Prepared prepared = prepare(place->reading);
    settle(*place, prepared);
  }

  /// Fuses the readings that are due at `now`. If the clock was set back, the filter's stamps follow; if it was set ahead, the robot is
  /// not predicted onwards. The estimate holds in both cases. `beat` measures the real time since the last step. If it is zero
  /// (simulated time), only the rates distinguish a gap from a clock that was set.
  void step(WallTime now, MonotonicTime beat = {});

  /// Keeps the estimate as it is, with `now` as its stamp, and drops what waits: instead of a step, while the filter is toggled off.
  /// Source: robot_localization, RosFilter::periodicUpdate.
  void hold(WallTime now, MonotonicTime beat = {});
  /// Sees everything that the filter does; null: nobody. Must outlive the filter.
  void observe(FilterObserver* observer) { observer_ = observer; }

  /// Resumes steps after a gap in which the robot's motion is unknown.
  void resume() { beat_ = last_beat_ = {}; }

  /// A commanded velocity (vx vy vz vroll vpitch vyaw), for FilterOptions::control.
  void command(const std::array<double, ControlOptions::kAxes>& velocity, WallTime stamp);

  struct Output {
    WallTime stamp;
    const Belief* belief;
  };
  /// The belief to publish at `now`, with a stamp newer than any before: the filter's own, or, if no measurement came since
  /// the last one, the same carried on to `now` (the filter itself is not moved by that). Nothing before the first
  /// measurement, or when the clock stands or went back.
  [[nodiscard]] std::optional<Output> output(WallTime now);

  /// Starts again from a pose at a stamp; everything older is ignored from now on.
  /// Errors: Covariance if the 6x6 block is not positive definite.
  [[nodiscard]] Prepared set_pose(const Reading& pose, WallTime stamp);
  /// Back to before the first measurement; counters stay.
  void reset();

  [[nodiscard]] bool initialised() const { return initialised_; }
  [[nodiscard]] const Belief& belief() const { return belief_; }
  [[nodiscard]] WallTime stamp() const { return stamp_; }
  [[nodiscard]] Duration period() const { return options_.period; }
  [[nodiscard]] Turning turning() const;
  [[nodiscard]] const PartStats& stats(std::size_t part) const { return parts_[part].stats; }
  /// What each part's innovations say of its noise and of the filter's uncertainty.
  [[nodiscard]] const Innovations& innovations() const { return innovations_; }
  /// The usual time between two messages of a part as they come; 0: not known yet.
  [[nodiscard]] Duration usual_interval(std::size_t part) const { return parts_[part].usual; }
  [[nodiscard]] const AssistState& assists() const { return assists_; }
  [[nodiscard]] std::uint64_t repairs() const { return repairs_; }
  /// How many measurements there is room for; grows with the inputs' rates.
  [[nodiscard]] std::size_t queue_places() const { return queue_.places(); }
  /// How often the wall clock was seen to be set (or no step came for more than ten seconds).
  [[nodiscard]] std::uint64_t clock_steps() const { return clock_steps_; }
  /// How often FilterOptions::reset_on_time_jump came into effect.
  [[nodiscard]] std::uint64_t time_resets() const { return time_resets_; }
  /// Null without FilterOptions::history.
  [[nodiscard]] const History* history() const { return history_ ? &*history_ : nullptr; }
  [[nodiscard]] const ReplayStats& replays() const { return replays_; }

 private:
  struct Part {
    PartStats stats;
    WallTime newest{};
    WallTime arrived{};     // when the last message came
    WallTime last_stamp{};  // of the last message, taken or not
    Duration usual{};       // between two messages as they come; 0: not known yet
    bool seen{false};
  };
  [[nodiscard]] Measurement* admit(std::uint16_t part, WallTime stamp, WallTime now);
  static void note_arrival(Part& part, WallTime stamp, WallTime now);
  [[nodiscard]] bool make_place(Part& part, WallTime stamp, WallTime now);
  void fuse_oldest();
  void settle(Measurement& place, const Prepared& prepared);
  void process(const Measurement& measurement, Pass pass);
  [[nodiscard]] bool initialise_from(const Reading& reading);
  void advance_to(WallTime stamp);
  void carry(Belief& belief, double dt_s, WallTime to) const;
  // Going back in time: replay.cpp.
  [[nodiscard]] FilterState state() const { return {belief_, assists_, stamp_, initialised_}; }
  void restore(const FilterState& state);
  void begin_history();
  void begin_replays();
  void take_in_order(const Measurement& measurement);
  void insert_late(const Measurement& measurement);
  void replay();
  void replay_one(History::Entry& entry);
  void make_room_in_history();
  void drop_pending(Rejection cause);
  void end_replays();
  void carry_in_pieces(Duration gap, WallTime to);
  void differentiate(WallTime now);
  [[nodiscard]] Duration slack_of_rates() const;
  [[nodiscard]] bool is_timed() const;
  [[nodiscard]] Duration passed() const;
  void drop_waiting(Rejection cause);
  void follow_clock_back(WallTime now);

  FilterOptions options_;
  Belief belief_;
  AssistState assists_;  // belongs to belief_
  Belief carried_;       // what output() publishes when the filter itself is older
  MeasurementQueue queue_;
  std::optional<History> history_;
  ReplayStats replays_;
  std::int64_t replay_budget_{0};   // instructions that are left for it in this step
  std::int64_t replay_surplus_{0};  // what the next step has more of it
  std::vector<Part> parts_;
  Innovations innovations_;
  WallTime stamp_{};
  WallTime proven_{};  // the newest stamp that the filter has stood at; newer than stamp_ only after going back
  WallTime last_step_{};
  WallTime last_output_{};
  WallTime last_set_pose_{};
  Eigen::Vector3d earlier_rates_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha_ = Eigen::Vector3d::Zero();
  WallTime differentiated_{};  // the time of earlier_rates_
  std::array<double, ControlOptions::kAxes> command_{};
  WallTime command_stamp_{};
  MonotonicTime beat_{};         // of the running step
  MonotonicTime last_beat_{};    // of the last one that moved or corrected the belief
  Duration slack_{};             // see the class
  std::size_t most_waiting_{0};  // since the last step
  std::uint64_t repairs_{0};
  std::uint64_t clock_steps_{0};
  std::uint64_t time_resets_{0};
  FilterObserver* observer_{nullptr};
  bool initialised_{false};
  bool jumped_{false};       // a clock that was set: what is older belongs to another time line
  bool corrected_{false};    // by a late measurement, since the last output
  bool fused_early_{false};  // before the step, for want of room
};

}  // namespace nacelle::ekf
