// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ekf/model/state.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::ekf {

/// A covariance as a parameter file gives it.
struct CovarianceParameter {
  StateMatrix matrix;
  std::string note;  ///< Worth a line in the log; empty if there is nothing to say.
};

/// Reads 15 numbers (the diagonal), 225 (row by row) or 36 (the 6x6 pose block; the rest is taken from `otherwise`).
///
/// Errors: a sentence for a person: another count, a number that is not finite, a negative variance, or a full matrix that is
///         not symmetric and positive semidefinite.
/// Source: robot_localization takes 15 and 225; 36 is how messages hold a pose covariance and is often copied from there.
[[nodiscard]] Result<CovarianceParameter, std::string> read_covariance(const std::vector<double>& numbers,
                                                                       const StateMatrix& otherwise);

/// robot_localization's defaults. Source: src/filter_base.cpp, FilterBase::reset.
[[nodiscard]] StateMatrix default_process_noise();
[[nodiscard]] StateMatrix default_initial_covariance();

}  // namespace nacelle::ekf
