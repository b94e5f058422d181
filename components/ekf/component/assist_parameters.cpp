// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/assist_parameters.hpp"

#include <fmt/format.h>

#include <cmath>
#include <type_traits>

namespace nacelle::ekf {
namespace {

constexpr StateMask kRates = mask_of(kVroll) | mask_of(kVpitch) | mask_of(kVyaw);

// Calls visit(name, value, text) for each number that can be set; the value is a double or a Duration.
template <typename Visit>
void each_number(AssistOptions& o, Visit&& visit) {
  visit("gyro_bias_stddev", o.gyro_bias.stddev_rps,
        "Standard deviation of the gyro's bias about each axis before anything is known of it, rad/s.");
  visit("gyro_bias_drift", o.gyro_bias.drift_rps_per_sqrt_s,
        "Random walk of the gyro's bias, rad/s per square root of s.");
  visit("standstill_time", o.standstill.time, "So long wheels and IMU must be quiet before the robot stands, s.");
  visit("standstill_speed", o.standstill.speed_mps, "Wheels that are slower stand, m/s.");
  visit("standstill_yaw_rate", o.standstill.yaw_rate_rps, "Wheels whose yaw rate is smaller stand, rad/s.");
  visit("standstill_gyro_limit", o.standstill.gyro_limit_rps,
        "A larger yaw rate of the gyro, its known bias taken off, is motion, rad/s.");
  visit("standstill_gyro_change", o.standstill.gyro_change_rps,
        "A rate that differs by more from what the gyro read when the wheels came to rest is motion, rad/s.");
  visit("standstill_force_change", o.standstill.force_change_mps2,
        "An acceleration that differs by more from what was read when the wheels came to rest is motion, m/s^2.");
  visit("standstill_speed_stddev", o.standstill.speed_stddev_mps, "Standard deviation of the zero speed, m/s.");
  visit("standstill_yaw_rate_stddev", o.standstill.yaw_rate_stddev_rps, "Standard deviation of the zero rates, rad/s.");
  visit("slip_yaw_rate", o.slip.yaw_rate_rps,
        "Wheels whose yaw rate differs by more from the gyro's slip, rad/s; a tenth of the rate is added.");
  visit("slip_speed", o.slip.speed_mps,
        "Wheels whose speed differs by more from the integral of the accelerometer slip, m/s.");
  visit("slip_inflation", o.slip.inflation,
        "The standard deviation that wheels gain while they slip, as a multiple of the difference.");
  visit("slip_wheel_separation", o.slip.wheel_separation_m,
        "Distance of the wheels, m: how a slipping wheel's yaw rate and speed belong together.");
  visit("slip_longest", o.slip.longest,
        "Wheels and IMU that disagree for longer, s: the IMU is wrong, and no slip is seen until they agree.");
}

Problem wrong_switch(const std::string& parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter), std::move(what), std::move(way_out)};
}

// The one input whose switch is on; null for none.
Result<const InputOptions*, Problem> only_one(const EkfOptions& options, bool InputOptions::*flag, const char* suffix) {
  const InputOptions* found = nullptr;
  for (const InputOptions& input : options.inputs) {
    if (!(input.*flag)) continue;
    if (found != nullptr)
      return err(
          wrong_switch(input.name + suffix, fmt::format("is true for {}, too", found->name), "choose one input"));
    found = &input;
  }
  return found;
}

Result<void, Problem> read_numbers(const Node& node, AssistOptions& assists) {
  Result<void, Problem> done;
  each_number(assists, [&](const char* name, auto& into, const char*) {
    const double value = node.get<double>(name);
    if (done && (!(value > 0.0) || !(value < 1e6)))
      done = err(wrong_switch(name, fmt::format("is {}", value), "give a positive number"));
    if constexpr (std::is_same_v<decltype(into), Duration&>) {
      if (done) into = from_seconds(value);
    } else {
      into = value;
    }
  });
  return done;
}

}  // namespace

void declare_assist_switches(Node& node, InputKind kind, const std::string& input) {
  const auto declare = [&](const char* suffix, const char* text) {
    node.declare_parameter(input + suffix, false, {.description = text, .read_only = true});
  };
  if (kind == InputKind::Imu)
    declare("_estimate_gyro_bias", "Estimate the gyro's bias as three more states; with two_d_mode that of yaw.");
  if (kind == InputKind::Odometry) {
    declare("_zero_velocity_updates", "Fuse velocities of 0 while these wheels stand and the IMU is quiet.");
    declare("_detect_slip", "Compare these wheels with the IMU, and trust them less while they slip.");
  }
  if (kind == InputKind::Odometry || kind == InputKind::Twist)
    declare("_teaches_gyro_bias",
            "Let its yaw rate correct the gyro's bias: not for wheels, whose separation is never exact.");
}

void declare_assist_numbers(Node& node) {
  AssistOptions defaults;
  each_number(defaults, [&](const char* name, auto& value, const char* text) {
    if constexpr (std::is_same_v<decltype(value), Duration&>) {
      node.declare_parameter(name, to_seconds(value), {.description = text, .read_only = true});
    } else {
      node.declare_parameter(name, value, {.description = text, .read_only = true});
    }
  });
}

void read_assist_switches(const Node& node, InputOptions& input) {
  const std::string& s = input.name;
  if (input.kind == InputKind::Imu) input.estimate_gyro_bias = node.get<bool>(s + "_estimate_gyro_bias");
  if (input.kind == InputKind::Odometry) {
    input.zero_velocity_updates = node.get<bool>(s + "_zero_velocity_updates");
    input.detect_slip = node.get<bool>(s + "_detect_slip");
  }
  if (input.kind == InputKind::Odometry || input.kind == InputKind::Twist)
    input.teaches_gyro_bias = node.get<bool>(s + "_teaches_gyro_bias");
}

Result<void, Problem> read_assists(const Node& node, EkfOptions& options) {
  AssistOptions& assists = options.filter.assists;
  if (const auto read = read_numbers(node, assists); !read) return err(read.error());
  const auto gyro = only_one(options, &InputOptions::estimate_gyro_bias, "_estimate_gyro_bias");
  if (!gyro) return err(gyro.error());
  const auto stands = only_one(options, &InputOptions::zero_velocity_updates, "_zero_velocity_updates");
  if (!stands) return err(stands.error());
  const auto slips = only_one(options, &InputOptions::detect_slip, "_detect_slip");
  if (!slips) return err(slips.error());
  if (*stands != nullptr && *slips != nullptr && *stands != *slips)
    return err(wrong_switch((*slips)->name + "_detect_slip",
                            fmt::format("is true while {} has the zero velocity updates", (*stands)->name),
                            "choose one input for both"));
  const InputOptions* const wheels = *stands != nullptr ? *stands : *slips;
  if (wheels != nullptr && (wheels->config & kTwistMask) == 0)
    return err(wrong_switch(wheels->name + "_config", "fuses no velocity, which zero velocity updates and slip need",
                            "set vx to true, or the switch to false"));
  const StateMask needed = options.filter.two_d_mode ? mask_of(kVyaw) : kRates;
  if (*gyro != nullptr && ((*gyro)->config & needed) == 0)
    return err(wrong_switch((*gyro)->name + "_config", "fuses no rate whose bias could be estimated",
                            "set vyaw to true, or the switch to false"));

  assists.gyro_bias.on = *gyro != nullptr;
  assists.gyro_bias.yaw_only = assists.standstill.two_d = options.filter.two_d_mode;
  assists.standstill.on = *stands != nullptr;
  assists.slip.on = *slips != nullptr;
  if (!assists.any()) return {};
  const InputOptions* imu = *gyro;
  for (InputOptions& input : options.inputs) {
    if (imu == nullptr && input.kind == InputKind::Imu && (input.config & kRates) != 0) imu = &input;
    if (&input == imu) input.witness = Witness::Source::Imu;
    if (&input == wheels) input.witness = Witness::Source::Wheels;
  }
  options.assist_imu = imu != nullptr ? imu->name : "";
  options.assist_wheels = wheels != nullptr ? wheels->name : "";
  if (imu == nullptr && assists.standstill.on)
    options.notes.push_back(
        fmt::format("{}_zero_velocity_updates: no IMU input measures a rate; the wheels alone decide", wheels->name));
  if (imu == nullptr && assists.slip.on)
    options.notes.push_back(
        fmt::format("{}_detect_slip: no IMU input measures a rate; no slip can be seen", wheels->name));
  return {};
}

}  // namespace nacelle::ekf
