// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nacelle::ekf {
namespace {

// So many usual intervals may pass before a stamp or a gap is no longer believed.
constexpr int kUsualIntervals = 10;
// And never more than this, however slow the inputs are.
constexpr Duration kMostSlack = 1s;
// After a longer pause between two steps the motion before it says nothing about the time since.
constexpr Duration kLongestPause = 10s;
// Farther behind the filter than this, the clock was set back.
constexpr Duration kClockStep = 1s;

// Of the state of row k with the states that the reading does not measure.
void clear_correlations(StateCovariance& covariance, const Reading& reading, int k) {
  const int at = reading.index[static_cast<std::size_t>(k)];
  for (int i = 0; i < kStates; ++i) {
    const auto* const end = reading.index.begin() + reading.rows;
    if (std::find(reading.index.begin(), end, i) == end) covariance(i, at) = covariance(at, i) = 0.0;
  }
}

}  // namespace

Filter::Filter(const FilterOptions& options)
    : options_(options),
      belief_(options.initial),
      assists_(unassisted(options.assists)),
      queue_(options.queue_limit, options.history ? Ties::ByPart : Ties::ByArrival),
      parts_(options.parts),
      innovations_(options.parts, options.innovations, options.two_d_mode ? kFlatStates : StateMask{0}) {
  slack_ = slack_of_rates();
  // Zeros on the diagonal are semidefinite: believed, but not to the last digit.
  if (!is_positive_definite(options_.initial.covariance)) {
    for (int i = 0; i < kStates; ++i) options_.initial.covariance(i, i) += kSmallestVariance;
    belief_ = options_.initial;
  }
  begin_history();
}

Measurement* Filter::admit(std::uint16_t part, WallTime stamp, WallTime now) {
  Part& p = parts_[part];
  note_arrival(p, stamp, now);
  const auto refuse = [&p](Rejection cause) -> Measurement* {
    ++p.stats.of(cause);
    return nullptr;
  };
  if (stamp <= WallTime{}) return refuse(Rejection::NoStamp);
  if (stamp > now + slack_) return refuse(Rejection::Future);
  if (last_set_pose_ != WallTime{} && stamp <= last_set_pose_) return refuse(Rejection::BeforeSetPose);
  if (p.seen && stamp < p.newest) return refuse(Rejection::Stale);
  if (history_ && !history_->holds(stamp)) {
    p.stats.late_by = stamp_ - stamp;
    return refuse(Rejection::BeforeHistory);
  }
  if (queue_.full() && !make_place(p, stamp, now)) return nullptr;
  Measurement& place = queue_.reserve();
  place.part = part;
  place.reading.witness = {};
  place.stamp = stamp;
  return &place;
}

void Filter::note_arrival(Part& part, WallTime stamp, WallTime now) {
  PartStats& stats = part.stats;
  stats.same_stamp = stats.received > 0 && stamp == part.last_stamp ? stats.same_stamp + 1 : 0;
  stats.behind = now - stamp;
  part.last_stamp = stamp;
  if (stats.received++ > 0 && now > part.arrived) {
    const Duration gap = now - part.arrived;
    // One gap, however long, makes an input only a little slower: the clock may have been set.
    part.usual = part.usual == 0ns ? gap : part.usual + (std::min(gap, 4 * part.usual) - part.usual) / 8;
  }
  part.arrived = now;
}

Duration Filter::slack_of_rates() const {
  Duration fastest = kMostSlack;
  bool known = false;
  for (const Part& part : parts_) {
    if (part.usual == 0ns) continue;
    fastest = std::min(fastest, part.usual);
    known = true;
  }
  const Duration longer = known ? std::max(fastest, options_.period) : options_.period;
  return std::min(kUsualIntervals * longer, kMostSlack);
}

// The queue has reached its limit. Due readings are fused now instead of at the step, in the same order, and none is lost. If none
// is due, the one that has to wait longest is dropped, so that an input whose clock is ahead does not stop the others.
bool Filter::make_place(Part& part, WallTime stamp, WallTime now) {
  if (queue_.oldest().stamp <= now) {
    fuse_oldest();
    fused_early_ = true;
    return true;
  }
  const Measurement& farthest = queue_.newest();
  if (farthest.stamp <= stamp) {
    ++part.stats.of(Rejection::QueueFull);
    return false;
  }
  PartStats& loser = parts_[farthest.part].stats;
  --loser.waiting;
  ++loser.of(Rejection::QueueFull);
  queue_.pop_newest();
  return true;
}

void Filter::settle(Measurement& place, const Prepared& prepared) {
  Part& p = parts_[place.part];
  if (!prepared) {
    ++p.stats.of(prepared.error());
    queue_.give_back(place);
    return;
  }
  p.newest = place.stamp;
  p.seen = true;
  ++p.stats.waiting;
  queue_.push(place);
  most_waiting_ = std::max(most_waiting_, queue_.size());
}

void Filter::fuse_oldest() {
  if (history_) {
    take_in_order(queue_.oldest());
  } else {
    --parts_[queue_.oldest().part].stats.waiting;
    process(queue_.oldest(), Pass::First);
  }
  queue_.pop_oldest();
}

void Filter::step(WallTime now, MonotonicTime beat) {
  beat_ = beat;
  slack_ = slack_of_rates();
  // Room for twice of what came, so that a late step needs none.
  queue_.make_places(2 * std::exchange(most_waiting_, 0));
  if (initialised_ && now < stamp_ - kClockStep) follow_clock_back(now);
  if (history_) begin_replays();
  const bool fused_early = std::exchange(fused_early_, false);
  bool fused_any = fused_early;
  const WallTime stood = proven_;
  while (!queue_.empty() && queue_.oldest().stamp <= now) {
    fuse_oldest();
    fused_any = true;
  }
  if (history_) {
    replay();
    fused_any = fused_early || proven_ > stood;  // what came late is no news of now
  }
  if (!initialised_) return;
  const WallTime heard = options_.timeout_from_stamp ? stamp_ : last_step_;
  const bool may_be_silent = !options_.timeout_from_stamp || queue_.empty();
  const bool silent = !fused_any && may_be_silent && now - heard >= options_.sensor_timeout;
  if ((silent || options_.predict_to_current_time) && now > stamp_) advance_to(now);
  if (silent || fused_any) {
    last_step_ = now;
    last_beat_ = beat;
  }
  differentiate(now);
  if (history_) end_replays();
}

void Filter::hold(WallTime now, MonotonicTime beat) {
  beat_ = beat;
  fused_early_ = false;
  drop_waiting(Rejection::Stale);
  if (!initialised_) return;
  stamp_ = last_step_ = proven_ = now;
  last_beat_ = beat;
  begin_history();
}

// The angular acceleration is a difference over steps, not over stamps: two inputs may stamp microseconds apart.
// Source: robot_localization, RosFilter::differentiateMeasurements.
void Filter::differentiate(WallTime now) {
  const Duration since = now - differentiated_;
  // A step that came late is followed by one that comes early: too short a time to divide by.
  if (since >= 0ns && since < options_.period / 2) return;
  const Eigen::Vector3d rates = belief_.mean.segment<3>(kVroll);
  if (differentiated_ != WallTime{} && since > 0ns) alpha_ = (rates - earlier_rates_) / to_seconds(since);
  earlier_rates_ = rates;
  differentiated_ = now;
}

void Filter::command(const std::array<double, ControlOptions::kAxes>& velocity, WallTime stamp) {
  command_ = velocity;
  command_stamp_ = stamp;
}

// The estimate holds, the stamps begin again. What waits was stamped by the old clock.
void Filter::follow_clock_back(WallTime now) {
  if (options_.reset_on_time_jump) {
    reset();
    last_output_ = {};
    ++time_resets_;
    return;
  }
  drop_waiting(Rejection::Stale);
  stamp_ = last_step_ = proven_ = now;
  last_output_ = now - Duration{1};
  last_set_pose_ = differentiated_ = command_stamp_ = {};
  forget_times(assists_);
  for (Part& p : parts_) p.seen = false;
  innovations_.restart();
  ++clock_steps_;
  begin_history();
}

void Filter::process(const Measurement& measurement, Pass pass) {
  PartStats& stats = parts_[measurement.part].stats;
  const bool counts = pass != Pass::Again;
  if (!initialised_) {
    const bool begun = initialise_from(measurement.reading);
    if (begun) stamp_ = measurement.stamp;
    proven_ = std::max(proven_, stamp_);
    if (counts) ++(begun ? stats.fused : stats.of(Rejection::Covariance));
    return;
  }
  const bool behind = measurement.stamp < stamp_;
  if (behind) {
    stats.late_by = stamp_ - measurement.stamp;
  } else {
    advance_to(measurement.stamp);
  }
  const Reading& reading = innovations_.note(measurement.part, measurement.stamp, belief_, measurement.reading);
  const auto fused = options_.assists.any() ? fuse(belief_, assists_, measurement.stamp, reading, options_.assists)
                                            : fuse(belief_, reading);
  if (observer_ != nullptr) observer_->corrected(measurement, fused, belief_);
  if (!counts) return;
  if (fused) {
    ++stats.fused;
    stats.late += behind || pass == Pass::Late ? 1U : 0U;
    repairs_ += fused->repaired ? 1U : 0U;
    return;
  }
  switch (fused.error()) {
    case UpdateFault::OutsideGate: ++stats.of(Rejection::Gate); break;
    case UpdateFault::SingularInnovation: ++stats.of(Rejection::Covariance); break;
    case UpdateFault::NoRows:
    case UpdateFault::NotFinite: ++stats.of(Rejection::NotFinite); break;
  }
}

// The first measurement initialises exactly the states that it measures.
bool Filter::initialise_from(const Reading& reading) {
  Belief first = belief_;
  for (std::size_t k = 0; k < static_cast<std::size_t>(reading.rows); ++k) {
    const int i = reading.index[k];
    first.mean[i] = i >= kRoll && i <= kYaw ? spatial::wrap_to_pi(reading.value[k]) : reading.value[k];
    for (std::size_t l = 0; l < static_cast<std::size_t>(reading.rows); ++l) {
      first.covariance(i, reading.index[l]) = reading.covariance[k * kStates + l];
    }
    first.covariance(i, i) = std::max(std::abs(first.covariance(i, i)), kSmallestVariance);
  }
  if (!first.mean.allFinite()) return false;
  // Correlations of the initial estimate with what is measured now may contradict the measurement's variances. They go.
  // robot_localization keeps them: its first covariance is none then.
  if (!is_positive_definite(first.covariance)) {
    for (int k = 0; k < reading.rows; ++k) clear_correlations(first.covariance, reading, k);
  }
  if (!is_positive_definite(first.covariance)) return false;
  belief_ = first;
  begin(belief_, assists_, reading, options_.assists);
  initialised_ = true;
  return true;
}

bool Filter::is_timed() const {
  return beat_ != MonotonicTime{} && last_beat_ != MonotonicTime{} && beat_ - last_beat_ <= kLongestPause;
}

// The time since a step last moved or corrected the belief. If it is unknown, the longest possible one.
Duration Filter::passed() const {
  return is_timed() ? beat_ - last_beat_ : options_.sensor_timeout + 2 * options_.period;
}

void Filter::advance_to(WallTime stamp) {
  Duration gap = stamp - stamp_;
  if (gap > 0ns) {
    // A longer gap than the time that has passed is a clock that was set: the motion before it says nothing about the time
    // since. robot_localization carries the robot on (FilterBase::validateDelta). What the filter has stood at is no gap.
    const WallTime known = std::max(stamp_, proven_);
    if (stamp - known > passed() + slack_) {
      gap = (known - stamp_) + (is_timed() ? passed() : options_.period);
      ++clock_steps_;
      jumped_ = true;
    }
    carry_in_pieces(gap, stamp);
    if (observer_ != nullptr) observer_->predicted(stamp, to_seconds(gap), belief_);
  }
  stamp_ = stamp;
  proven_ = std::max(proven_, stamp);
}

void Filter::carry(Belief& belief, double dt_s, WallTime to) const {
  StateVector commanded = belief.mean;
  if (options_.control.any()) {
    const bool fresh = to - command_stamp_ < options_.control.timeout;
    apply_control(commanded, fresh ? command_ : decltype(command_){}, dt_s, options_.control);
  }
  if (options_.dynamic_process_noise) {
    advance(belief, commanded, dt_s, scaled_by_velocity(options_.process_noise, belief.mean));
  } else {
    advance(belief, commanded, dt_s, options_.process_noise);
  }
}

std::optional<Filter::Output> Filter::output(WallTime now) {
  if (!initialised_) return std::nullopt;
  const bool again = std::exchange(corrected_, false) && options_.permit_corrected_publication;
  if (stamp_ > last_output_ || again) {
    last_output_ = std::max(last_output_, stamp_);
    return Output{stamp_, &belief_};
  }
  if (now <= last_output_) return std::nullopt;
  carried_ = belief_;
  // Stamps that stand still, or lag behind, must not carry the robot away.
  carry(carried_, to_seconds(std::min(now - stamp_, passed() + slack_)), now);
  last_output_ = now;
  return Output{now, &carried_};
}

Prepared Filter::set_pose(const Reading& pose, WallTime stamp) {
  Belief told;
  for (int i = 0; i < kStates; ++i) told.covariance(i, i) = 1e-6;  // robot_localization, setPoseCallback
  for (std::size_t k = 0; k < static_cast<std::size_t>(pose.rows); ++k) {
    told.mean[pose.index[k]] = pose.value[k];
    for (std::size_t l = 0; l < static_cast<std::size_t>(pose.rows); ++l) {
      told.covariance(pose.index[k], pose.index[l]) = pose.covariance[k * kStates + l];
    }
    double& variance = told.covariance(pose.index[k], pose.index[k]);
    variance = std::max(std::abs(variance), kSmallestVariance);
  }
  if (!told.mean.allFinite()) return err(Rejection::NotFinite);
  if (!is_positive_definite(told.covariance)) return err(Rejection::Covariance);
  drop_waiting(Rejection::BeforeSetPose);
  belief_ = told;
  forget_belief(assists_);
  initialised_ = true;
  stamp_ = last_set_pose_ = last_step_ = proven_ = stamp;
  last_beat_ = beat_;
  alpha_.setZero();
  differentiated_ = {};
  for (Part& p : parts_) p.seen = false;
  innovations_.restart();
  begin_history();
  return {};
}

void Filter::reset() {
  drop_waiting(Rejection::Stale);
  belief_ = options_.initial;
  assists_ = unassisted(options_.assists);
  initialised_ = false;
  stamp_ = last_step_ = last_set_pose_ = proven_ = differentiated_ = command_stamp_ = {};
  last_beat_ = {};
  fused_early_ = false;
  alpha_.setZero();
  for (Part& p : parts_) p.seen = false;
  innovations_.restart();
  begin_history();
}

void Filter::drop_waiting(Rejection cause) {
  while (!queue_.empty()) {
    PartStats& stats = parts_[queue_.oldest().part].stats;
    --stats.waiting;
    ++stats.of(cause);
    queue_.pop_oldest();
  }
  if (history_) drop_pending(cause);
}

Turning Filter::turning() const { return {belief_.mean.segment<3>(kVroll), alpha_}; }

}  // namespace nacelle::ekf
