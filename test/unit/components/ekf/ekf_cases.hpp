// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "ekf/model/state.hpp"

namespace nacelle::ekf {

/// A state that is far from the poles of the angles and from zero.
inline StateVector random_state(std::mt19937& random) {
  std::uniform_real_distribution<double> any{-1.2, 1.2};
  StateVector x;
  for (double& value : x) value = any(random);
  return x;
}

/// A covariance with correlations, eigenvalues from about 0.01 to some tens.
inline StateMatrix random_covariance(std::mt19937& random) {
  std::normal_distribution<double> normal;
  StateMatrix half;
  for (double& value : half.reshaped()) value = normal(random);
  return half * half.transpose() * 0.3 + StateMatrix::Identity() * 0.01;
}

}  // namespace nacelle::ekf
