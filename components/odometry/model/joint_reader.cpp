// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/joint_reader.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::odometry {
namespace {

constexpr double kShortestStep_s = 1e-4;  // diff_drive_controller: shorter ones divide noise by nothing
constexpr double kLongestBlind_s = 0.5;   // speeds alone: what happened in a longer gap is not known

}  // namespace

JointReader::JointReader(const JointReaderOptions& options)
    : left_(side_of(options.left_names, options.left_radius_m, options.position_range_rad)),
      right_(side_of(options.right_names, options.right_radius_m, options.position_range_rad)),
      max_wheel_speed_rps_(options.max_wheel_speed_rps) {}

JointReader::Side JointReader::side_of(const std::vector<std::string>& names, double radius_m, double range_rad) {
  Side side{{}, radius_m};
  for (const auto& name : names) side.wheels.push_back({name, 0, PositionUnwrap{range_rad}, 0.0});
  return side;
}

void JointReader::restart() {
  last_.reset();
  oldest_s_ = 0.0;
  for (Side* side : {&left_, &right_}) {
    for (Wheel& wheel : side->wheels) wheel.unwrap.restart();
  }
}

bool JointReader::find(Side& side, std::span<const std::string> names) {
  for (Wheel& wheel : side.wheels) {
    if (wheel.place < names.size() && names[wheel.place] == wheel.name) continue;
    wheel.place = static_cast<std::size_t>(std::find(names.begin(), names.end(), wheel.name) - names.begin());
    if (wheel.place == names.size()) return false;
  }
  return true;
}

bool JointReader::is_finite(const Side& side, std::span<const double> values) {
  return std::all_of(side.wheels.begin(), side.wheels.end(),
                     [&](const Wheel& wheel) { return std::isfinite(values[wheel.place]); });
}

std::optional<double> JointReader::step_of(Side& side, const Values& values, double dt_s) const {
  // After a pause the positions that come may be as old as it was long: the line is emptied in the order in which it was filled.
  const double most_rad = max_wheel_speed_rps_ * (dt_s + oldest_s_);
  double sum_rad = 0.0;
  bool jumped = false;
  for (Wheel& wheel : side.wheels) {
    const bool is_measured = !values.speeds_rps.empty() && std::isfinite(values.speeds_rps[wheel.place]);
    const double before_rps = wheel.speed_rps;
    if (is_measured) wheel.speed_rps = values.speeds_rps[wheel.place];
    // The mean of the speeds at both ends; without a measured one the wheel turns on as it did.
    const double expected_rad = 0.5 * (before_rps + wheel.speed_rps) * dt_s;
    if (values.positions_rad.empty()) {
      sum_rad += expected_rad;
      continue;
    }
    const auto step_rad = wheel.unwrap.step(values.positions_rad[wheel.place], most_rad, expected_rad, is_measured);
    jumped = jumped || !step_rad;
    if (!is_measured) wheel.speed_rps = step_rad && dt_s > 0.0 ? *step_rad / dt_s : 0.0;
    sum_rad += step_rad.value_or(0.0);
  }
  if (jumped) return std::nullopt;
  return sum_rad / static_cast<double>(side.wheels.size());
}

std::optional<JointReader::Step> JointReader::start(WallTime stamp, const Values& values) {
  restart();
  static_cast<void>(step_of(left_, values, 0.0));
  static_cast<void>(step_of(right_, values, 0.0));
  last_ = stamp;
  return std::nullopt;
}

std::optional<JointReader::Step> JointReader::read(WallTime stamp, std::span<const std::string> names,
                                                   std::span<const double> positions_rad,
                                                   std::span<const double> speeds_rps) {
  ++stats_.samples;
  const Values values{positions_rad, speeds_rps.size() == names.size() ? speeds_rps : std::span<const double>{}};
  if (names.empty() || values.counting().size() != names.size() || !find(left_, names) || !find(right_, names)) {
    ++stats_.incomplete;
    return std::nullopt;
  }
  if (!is_finite(left_, values.counting()) || !is_finite(right_, values.counting())) {
    ++stats_.not_finite;
    return std::nullopt;
  }
  if (!last_) {
    ++stats_.first;
    return start(stamp, values);
  }
  const double dt_s = to_seconds(stamp - *last_);
  if (dt_s < 0.0) {
    ++stats_.time_jumps;
    return start(stamp, values);
  }
  if (dt_s < kShortestStep_s) {
    ++stats_.repeated;
    return std::nullopt;
  }
  if (positions_rad.empty() && dt_s > kLongestBlind_s) {
    ++stats_.gaps;
    return start(stamp, values);
  }
  last_ = stamp;
  const auto left_rad = step_of(left_, values, dt_s);
  const auto right_rad = step_of(right_, values, dt_s);
  oldest_s_ = std::max(oldest_s_ - dt_s, dt_s);
  if (!left_rad || !right_rad) {
    ++stats_.jumps;
    return std::nullopt;
  }
  ++stats_.steps;
  return Step{{*left_rad * left_.radius_m, *right_rad * right_.radius_m}, dt_s};
}

}  // namespace nacelle::odometry
