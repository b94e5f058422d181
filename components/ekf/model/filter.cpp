// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/filter.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::ekf {
namespace {

// A longer gap is a clock that was set, or a filter that was switched off: the motion before it says nothing about the time
// since. step() comes at the output's rate, so that silent sensors make no gap. robot_localization waits for 100000 s
// (FilterBase::validateDelta) and drives on until then; the 0.01 s are its.
constexpr double kLongestGap_s = 10.0;
constexpr double kGapInstead_s = 0.01;
// Farther behind the filter than this, the clock was set back.
constexpr Duration kClockStep = 1s;

}  // namespace

Filter::Filter(const FilterOptions& options)
    : options_(options), belief_(options.initial), queue_(options.queue_capacity), parts_(options.parts) {
  // Zeros on the diagonal are semidefinite: believed, but not to the last digit.
  if (!is_positive_definite(options_.initial.covariance)) {
    for (int i = 0; i < kStates; ++i) options_.initial.covariance(i, i) += kSmallestVariance;
    belief_ = options_.initial;
  }
}

Measurement* Filter::admit(std::uint16_t part, WallTime stamp) {
  Part& p = parts_[part];
  ++p.stats.received;
  if (last_set_pose_ != WallTime{} && stamp <= last_set_pose_) {
    ++p.stats.of(Rejection::BeforeSetPose);
    return nullptr;
  }
  if (p.seen && stamp < p.newest) {
    ++p.stats.of(Rejection::Stale);
    return nullptr;
  }
  if (queue_.full()) {
    // Only stamps from the future can fill the queue; the farthest goes first, so that one bad clock does not stop the rest.
    const Measurement& farthest = queue_.newest();
    if (farthest.stamp <= stamp) {
      ++p.stats.of(Rejection::QueueFull);
      return nullptr;
    }
    PartStats& loser = parts_[farthest.part].stats;
    --loser.waiting;
    ++loser.of(Rejection::QueueFull);
    queue_.pop_newest();
  }
  Measurement& place = queue_.reserve();
  place.part = part;
  place.stamp = stamp;
  return &place;
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
}

void Filter::step(WallTime now) {
  if (initialised_ && now < stamp_ - kClockStep) follow_clock_back(now);
  bool fused_any = false;
  while (!queue_.empty() && queue_.oldest().stamp <= now) {
    --parts_[queue_.oldest().part].stats.waiting;
    process(queue_.oldest());
    queue_.pop_oldest();
    fused_any = true;
  }
  if (initialised_) {
    const bool silent = !fused_any && now - last_step_ >= options_.sensor_timeout;
    if ((silent || options_.predict_to_current_time) && now > stamp_) advance_to(now);
    if (silent || fused_any) last_step_ = now;
    if (stamp_ > earlier_stamp_) {
      const Eigen::Vector3d rates = belief_.mean.segment<3>(kVroll);
      if (earlier_stamp_ != WallTime{}) alpha_ = (rates - earlier_rates_) / to_seconds(stamp_ - earlier_stamp_);
      earlier_rates_ = rates;
      earlier_stamp_ = stamp_;
    }
  }
}

// The estimate holds, the stamps begin again. What waits was stamped by the old clock.
void Filter::follow_clock_back(WallTime now) {
  drop_waiting(Rejection::Stale);
  stamp_ = last_step_ = now;
  last_output_ = now - Duration{1};
  last_set_pose_ = earlier_stamp_ = {};
  for (Part& p : parts_) p.seen = false;
  ++clock_steps_;
}

void Filter::process(const Measurement& measurement) {
  PartStats& stats = parts_[measurement.part].stats;
  if (!initialised_) {
    if (!initialise_from(measurement.reading)) {
      ++stats.of(Rejection::Covariance);
      return;
    }
    stamp_ = measurement.stamp;
    ++stats.fused;
    return;
  }
  const bool late = measurement.stamp < stamp_;
  if (!late) advance_to(measurement.stamp);
  const auto fused = fuse(belief_, measurement.reading);
  if (fused) {
    ++stats.fused;
    stats.late += late ? 1U : 0U;
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

// The first measurement is believed as it is, and only in what it measures.
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
  if (!first.mean.allFinite() || !is_positive_definite(first.covariance)) return false;
  belief_ = first;
  initialised_ = true;
  return true;
}

void Filter::advance_to(WallTime stamp) {
  double dt_s = to_seconds(stamp - stamp_);
  if (dt_s > kLongestGap_s) {
    dt_s = kGapInstead_s;
    ++clock_steps_;
  }
  if (dt_s > 0.0) {
    if (options_.dynamic_process_noise) {
      advance(belief_, dt_s, scaled_by_velocity(options_.process_noise, belief_.mean));
    } else {
      advance(belief_, dt_s, options_.process_noise);
    }
  }
  stamp_ = stamp;
}

std::optional<Filter::Output> Filter::output(WallTime now) {
  if (!initialised_) return std::nullopt;
  if (stamp_ > last_output_) {
    last_output_ = stamp_;
    return Output{stamp_, &belief_};
  }
  if (now <= last_output_) return std::nullopt;
  carried_ = belief_;
  advance(carried_, std::min(to_seconds(now - stamp_), kLongestGap_s), options_.process_noise);
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
  initialised_ = true;
  stamp_ = last_set_pose_ = last_step_ = stamp;
  alpha_.setZero();
  earlier_stamp_ = {};
  for (Part& p : parts_) p.seen = false;
  return {};
}

void Filter::reset() {
  drop_waiting(Rejection::Stale);
  belief_ = options_.initial;
  initialised_ = false;
  stamp_ = last_step_ = last_set_pose_ = earlier_stamp_ = {};
  alpha_.setZero();
  for (Part& p : parts_) p.seen = false;
}

void Filter::drop_waiting(Rejection cause) {
  while (!queue_.empty()) {
    PartStats& stats = parts_[queue_.oldest().part].stats;
    --stats.waiting;
    ++stats.of(cause);
    queue_.pop_oldest();
  }
}

Turning Filter::turning() const { return {belief_.mean.segment<3>(kVroll), alpha_}; }

}  // namespace nacelle::ekf
