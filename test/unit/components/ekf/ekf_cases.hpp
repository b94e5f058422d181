// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <random>
#include <vector>

#include "ekf/model/state.hpp"

namespace nacelle::ekf {

/// The 15 booleans of a `_config` parameter.
inline std::vector<bool> config_of(std::initializer_list<int> states) {
  std::vector<bool> config(kStates, false);
  for (const int i : states) config[static_cast<std::size_t>(i)] = true;
  return config;
}

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
