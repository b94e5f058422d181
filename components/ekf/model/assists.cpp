// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/assists.hpp"

#include <cmath>

namespace nacelle::ekf {
namespace {

bool is_of_gyro(const Reading& reading, const AssistOptions& options) {
  return options.gyro_bias.on && reading.witness.source == Witness::Source::Imu;
}

Result<Fused, UpdateFault> fuse_one(Belief& belief, AssistState& state, const Reading& reading,
                                    const AssistOptions& options) {
  if (!options.gyro_bias.on) return fuse(belief, reading);
  return fuse(belief, state.gyro_bias, reading, is_of_gyro(reading, options), options.gyro_bias);
}

void see_imu(AssistState& state, WallTime stamp, const Witness& imu, const AssistOptions& options) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) sum += imu.angular[i] + imu.linear[i];
  if (!std::isfinite(sum)) return;
  const bool known = options.gyro_bias.on;
  const double bias = known ? state.gyro_bias.mean_rps.z() : 0.0;
  const double bias_stddev = known ? std::sqrt(state.gyro_bias.covariance(2, 2)) : -1.0;
  if (options.standstill.on) state.standstill.see_imu(stamp, imu, bias, bias_stddev, options.standstill);
  if (options.slip.on) state.slip.see_imu(stamp, imu, imu.angular[2] - bias);
}

void add_doubt(const Doubt& doubt, Reading& reading) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(reading.rows); ++k) {
    double& variance = reading.covariance[k * (kStates + 1)];
    if (reading.index[k] == kVx) variance += doubt.speed_mps2;
    if (reading.index[k] == kVyaw) variance += doubt.yaw_rate_rps2;
  }
}

}  // namespace

AssistState unassisted(const AssistOptions& options) {
  AssistState state;
  state.gyro_bias = unknown_bias(options.gyro_bias);
  return state;
}

void begin(Belief& belief, AssistState& state, const Reading& first, const AssistOptions& options) {
  if (is_of_gyro(first, options)) take_bias_off(belief, state.gyro_bias, first, options.gyro_bias);
}

void forget_belief(AssistState& state) {
  state.gyro_bias.cross.setZero();
  forget_times(state);
}

void forget_times(AssistState& state) {
  state.standstill.forget_times();
  state.slip.forget_times();
}

void advance(AssistState& state, const StateVector& before, double dt_s, const AssistOptions& options) {
  if (options.gyro_bias.on) advance(state.gyro_bias, before, dt_s, options.gyro_bias);
}

Result<Fused, UpdateFault> fuse(Belief& belief, AssistState& state, WallTime stamp, const Reading& reading,
                                const AssistOptions& options) {
  const Witness& witness = reading.witness;
  if (witness.source == Witness::Source::Imu) see_imu(state, stamp, witness, options);
  if (witness.source != Witness::Source::Wheels) return fuse_one(belief, state, reading, options);

  Doubt doubt;
  if (options.slip.on) doubt = state.slip.see_wheels(stamp, witness, options.slip);
  if (options.standstill.on) state.standstill.see_wheels(stamp, witness, options.standstill);
  Reading doubted;
  if (doubt.any()) {
    doubted = reading;
    add_doubt(doubt, doubted);
  }
  const auto fused = fuse_one(belief, state, doubt.any() ? doubted : reading, options);
  if (!options.standstill.on || !state.standstill.standing) return fused;
  Reading zero;
  write_zero_velocity(options.standstill, zero);
  if (fuse_one(belief, state, zero, options)) ++state.standstill.updates;
  return fused;
}

}  // namespace nacelle::ekf
