// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/model/gyro_bias.hpp"
#include "ekf/model/slip.hpp"
#include "ekf/model/standstill.hpp"
#include "ekf/model/update.hpp"

namespace nacelle::ekf {

/// What makes the estimate better than robot_localization's. Each is a switch; with all of them off nothing here runs.
struct AssistOptions {
  GyroBiasOptions gyro_bias;
  StandstillOptions standstill;
  SlipOptions slip;
  [[nodiscard]] bool any() const { return gyro_bias.on || standstill.on || slip.on; }
};

/// All that the assists remember. A filter that goes back in time restores it together with the belief.
struct AssistState {
  GyroBias gyro_bias;
  Standstill standstill;
  Slip slip;
};
static_assert(sizeof(AssistState) <= 1024);

/// Before the first measurement.
[[nodiscard]] AssistState unassisted(const AssistOptions& options);
/// The belief was made anew from `first`, which alone is fused so far.
void begin(Belief& belief, AssistState& state, const Reading& first, const AssistOptions& options);
/// The belief was set from outside: what it has in common with the bias is unknown. The bias stays.
void forget_belief(AssistState& state);
/// The clock was set back: no time of before can be compared.
void forget_times(AssistState& state);

/// Beside ekf::advance() of the belief, from the mean `before`.
void advance(AssistState& state, const StateVector& before, double dt_s, const AssistOptions& options);

/// In the place of ekf::fuse(): judges what the measurement says of standstill and slip, and fuses it with the gyro's bias.
/// Threads: pure. Allocates: nothing.
[[nodiscard]] Result<Fused, UpdateFault> fuse(Belief& belief, AssistState& state, WallTime stamp,
                                              const Reading& reading, const AssistOptions& options);

}  // namespace nacelle::ekf
