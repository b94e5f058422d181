// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/model/state.hpp"

namespace nacelle::ekf {

/// Moves a state on: constant acceleration along the axes of the body, which turns at constant rates.
///
/// Units:     SI; dt_s may be negative.
/// Threads:   pure. Allocates: nothing.
/// Source:    robot_localization, src/ekf.cpp, Ekf::predict (transfer function). Singular at pitch = +-90 deg.
[[nodiscard]] StateVector propagate(const StateVector& from, double dt_s);

/// d propagate / d from, dense. predict() uses its structure instead; this one is for tests and for reading.
[[nodiscard]] StateMatrix jacobian(const StateVector& from, double dt_s);

/// How much uncertainty comes in per second. Made once; knows whether it is diagonal, as it nearly always is.
struct ProcessNoise {
  StateCovariance rate;
  bool diagonal{true};

  ProcessNoise() = default;
  explicit ProcessNoise(const StateMatrix& per_s) : rate(per_s), diagonal(per_s.isDiagonal(0.0)) {}
};

/// Moves a belief dt_s on: mean by propagate(), covariance J P J^T + dt Q, symmetric to the last bit.
///
/// Cost:      about 4500 instructions, against 50,000 for the dense products.
/// Threads:   pure. Allocates: nothing.
/// Source:    robot_localization, Ekf::predict; Q is a rate there too.
void advance(Belief& belief, double dt_s, const ProcessNoise& noise);
/// The same of a belief that a command changes: the mean is that of `commanded`, the covariance is moved as without the command.
/// Source: robot_localization, Ekf::predict, which makes its Jacobian before it applies the control terms.
void advance(Belief& belief, const StateVector& commanded, double dt_s, const ProcessNoise& noise);
[[nodiscard]] inline Belief predict(const Belief& from, double dt_s, const ProcessNoise& noise) {
  Belief to = from;
  advance(to, dt_s, noise);
  return to;
}

/// Process noise whose pose block grows with the square of the velocity, so that the uncertainty of a stationary robot
/// does not grow.
/// Source: robot_localization, FilterBase::computeDynamicProcessNoiseCovariance: V Q V^T, V = |velocity| I.
[[nodiscard]] ProcessNoise scaled_by_velocity(const ProcessNoise& noise, const StateVector& state);

}  // namespace nacelle::ekf
