// SPDX-License-Identifier: Apache-2.0
#include "odometry/component/odometry_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "nacelle/node/frame_name.hpp"
#include "odometry/component/slip_parameters.hpp"

namespace nacelle::odometry {
namespace {

Problem wrong(const char* parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter), std::move(what), std::move(way_out)};
}

std::vector<double> listed(const std::array<double, 6>& values) { return {values.begin(), values.end()}; }

}  // namespace

Result<OdometryOptions, Problem> validated(OdometryOptions o) {
  if (o.left_wheel_names.empty())
    return err(wrong("left_wheel_names", "is empty", "name the joints of the left wheels"));
  if (o.left_wheel_names.size() != o.right_wheel_names.size()) {
    return err(wrong(
        "right_wheel_names",
        fmt::format("has {} names, left_wheel_names has {}", o.right_wheel_names.size(), o.left_wheel_names.size()),
        "name one joint per wheel on both sides"));
  }
  const std::pair<const char*, double> positive[] = {{"wheel_separation", o.wheel_separation_m},
                                                     {"wheel_radius", o.wheel_radius_m},
                                                     {"wheel_separation_multiplier", o.wheel_separation_multiplier},
                                                     {"left_wheel_radius_multiplier", o.left_wheel_radius_multiplier},
                                                     {"right_wheel_radius_multiplier", o.right_wheel_radius_multiplier},
                                                     {"max_wheel_speed", o.max_wheel_speed_rps}};
  for (const auto& [name, value] : positive) {
    if (!(value > 0.0) || !std::isfinite(value))
      return err(wrong(name, fmt::format("is {}", value), "give a positive number"));
  }
  const StepNoise noise = o.noise.value_or(StepNoise{});
  const std::pair<const char*, double> not_negative[] = {{"k_left", noise.k_left_m},
                                                         {"k_right", noise.k_right_m},
                                                         {"k_turn", noise.k_turn_rad},
                                                         {"slip.distance_stddev_per_sqrt_m", o.slip.distance_m},
                                                         {"slip.lateral_stddev_per_sqrt_m", o.slip.lateral_m},
                                                         {"slip.heading_stddev_per_sqrt_m", o.slip.heading_rad},
                                                         {"slip.heading_stddev_per_sqrt_rad", o.slip.turn_rad},
                                                         {"position_range", o.position_range_rad}};
  for (const auto& [name, value] : not_negative) {
    if (!(value >= 0.0) || !std::isfinite(value))
      return err(wrong(name, fmt::format("is {}", value), "give 0 or more"));
  }
  const std::pair<const char*, const std::array<double, 6>*> diagonals[] = {
      {"pose_covariance_diagonal", &o.pose_covariance_diagonal},
      {"twist_covariance_diagonal", &o.twist_covariance_diagonal}};
  for (const auto& [name, values] : diagonals) {
    for (const double value : *values) {
      if (!(value >= 0.0) || !std::isfinite(value)) {
        return err(wrong(name, fmt::format("holds {}", value), "a variance is 0 or more"));
      }
    }
  }
  if (o.velocity_rolling_window_size < 1) {
    return err(
        wrong("velocity_rolling_window_size", fmt::format("is {}", o.velocity_rolling_window_size), "give 1 or more"));
  }
  if (o.odom_frame_id.empty()) return err(wrong("odom_frame_id", "is empty", "give it a name, e.g. odom"));
  if (o.base_frame_id.empty()) return err(wrong("base_frame_id", "is empty", "give it a name, e.g. base_link"));
  if (o.odom_frame_id == o.base_frame_id) {
    return err(wrong("base_frame_id", fmt::format("'{}' is odom_frame_id, too", o.base_frame_id), "give two names"));
  }
  return o;
}

void declare_odometry_parameters(Node& node, const OdometryOptions& d) {
  const auto say = [](const char* text) { return ParameterDescriptor{.description = text, .read_only = true}; };
  node.declare_parameter("left_wheel_names", d.left_wheel_names,
                         say("Joints of the left wheels; their mean counts. Not given: the base's, if it is there."));
  node.declare_parameter("right_wheel_names", d.right_wheel_names,
                         say("Joints of the right wheels. Not given: the base's, if it is there."));
  node.declare_parameter(
      "wheel_separation", d.wheel_separation_m,
      say("Between the middles of left and right wheels, m. Not given: the base's, if it is there."));
  node.declare_parameter("wheel_radius", d.wheel_radius_m,
                         say("Radius of a wheel, m. Not given: the base's, if it is there."));
  node.declare_parameter("wheel_separation_multiplier", d.wheel_separation_multiplier,
                         say("Calibration of the separation. Not given: with the base's separation comes its own."));
  node.declare_parameter("left_wheel_radius_multiplier", d.left_wheel_radius_multiplier,
                         say("Calibration of the left radius. Not given: with the base's radius comes its own."));
  node.declare_parameter("right_wheel_radius_multiplier", d.right_wheel_radius_multiplier,
                         say("Calibration of the right radius. Not given: with the base's radius comes its own."));
  declare_frame_prefix(node);
  node.declare_parameter("odom_frame_id", d.odom_frame_id, say("Parent frame of the odometry."));
  node.declare_parameter("base_frame_id", d.base_frame_id, say("Child frame of the odometry."));
  node.declare_parameter("pose_covariance_diagonal", listed(d.pose_covariance_diagonal),
                         say("x y z roll pitch yaw: the variances at the start; x, y and yaw grow from there."));
  node.declare_parameter("twist_covariance_diagonal", listed(d.twist_covariance_diagonal),
                         say("x y z roll pitch yaw: the least variances; x and yaw grow with the speed."));
  node.declare_parameter("enable_odom_tf", d.enable_odom_tf,
                         say("Broadcast odom -> base unless another node owns the frame."));
  node.declare_parameter("velocity_rolling_window_size", d.velocity_rolling_window_size,
                         say("Steps that the published twist is the mean of. A mean lags by half its window."));
  declare_slip_parameters(node, d.slip);
  node.declare_parameter(
      "max_wheel_speed", d.max_wheel_speed_rps,
      say("rad/s; a faster change of a position is the end of a circle, or a restart of the board, which does not move "
          "the robot."));
  node.declare_parameter(
      "position_range", d.position_range_rad,
      say("rad after which a wheel's position begins anew: 6.283185307 for one turn, 100.530964915 for 65536 steps of "
          "4096 a turn. 0: found out for one turn (-pi to pi, or 0 to 2 pi) and for counters of 2^n steps, n from 8."));
}

Result<OdometryOptions, Problem> read_odometry_parameters(const Node& node) {
  OdometryOptions o;
  const auto real = [&node](const char* name) { return node.get<double>(name); };
  o.left_wheel_names = node.get<std::vector<std::string>>("left_wheel_names");
  o.right_wheel_names = node.get<std::vector<std::string>>("right_wheel_names");
  o.wheel_separation_m = real("wheel_separation");
  o.wheel_radius_m = real("wheel_radius");
  o.wheel_separation_multiplier = real("wheel_separation_multiplier");
  o.left_wheel_radius_multiplier = real("left_wheel_radius_multiplier");
  o.right_wheel_radius_multiplier = real("right_wheel_radius_multiplier");
  o.odom_frame_id = frame_name(node, "odom_frame_id");
  o.base_frame_id = frame_name(node, "base_frame_id");
  const std::pair<const char*, std::array<double, 6>*> diagonals[] = {
      {"pose_covariance_diagonal", &o.pose_covariance_diagonal},
      {"twist_covariance_diagonal", &o.twist_covariance_diagonal}};
  for (const auto& [name, into] : diagonals) {
    const auto values = node.get<std::vector<double>>(name);
    if (values.size() != into->size()) {
      return err(wrong(name, fmt::format("has {} numbers", values.size()), "give 6: x y z roll pitch yaw"));
    }
    std::copy(values.begin(), values.end(), into->begin());
  }
  o.enable_odom_tf = node.get<bool>("enable_odom_tf");
  o.velocity_rolling_window_size = static_cast<int>(node.get<std::int64_t>("velocity_rolling_window_size"));
  o.slip = read_slip_model(node);
  o.noise = read_step_noise(node);
  o.max_wheel_speed_rps = real("max_wheel_speed");
  o.position_range_rad = real("position_range");
  return validated(std::move(o));
}

}  // namespace nacelle::odometry
