// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "ekf/model/state.hpp"
#include "ekf/model/witness.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::ekf {

/// What a sensor says about some of the states. `rows` of everything are in use.
struct Reading {
  int rows{};
  std::array<std::uint8_t, kStates> index{};  ///< The state that row k measures; each state at most once.
  std::array<double, kStates> value{};        ///< Angles may be any multiple of a turn away.
  std::array<double, static_cast<std::size_t>(kStates) * kStates>
      covariance{};                                      ///< R, row k column l at [k * kStates + l]; symmetric.
  double gate{std::numeric_limits<double>::infinity()};  ///< Largest Mahalanobis distance, not squared.
  Witness witness;

  /// Appends a row whose error is independent of the others'.
  void add(StateIndex state, double z, double variance) {
    const auto k = static_cast<std::size_t>(rows);
    index[k] = state;
    value[k] = z;
    for (std::size_t l = 0; l < k; ++l) covariance[k * kStates + l] = covariance[l * kStates + k] = 0.0;
    covariance[k * kStates + k] = variance;
    ++rows;
  }
};

/// A variance below this is a claim that no sensor can keep; it is raised. Source: robot_localization, Ekf::correct.
inline constexpr double kSmallestVariance = 1e-9;

enum class UpdateFault : std::uint8_t {
  NoRows,              ///< Nothing to fuse.
  NotFinite,           ///< A value or a covariance entry is NaN or infinite.
  SingularInnovation,  ///< H P H^T + R has no Cholesky factor: R is not a covariance.
  OutsideGate,         ///< Mahalanobis distance at or above the gate.
};

struct Fused {
  double
      mahalanobis_squared{};  ///< Of the innovation; chi-squared with `rows` degrees of freedom if the model is right.
  bool repaired{};            ///< Rounding had cost the covariance its definiteness; a multiple of I was added.
};
struct Updated {
  Belief belief;
  Fused fused;
};

/// Fuses a reading into a belief. On a fault the belief stands as it was.
///
/// Cost:      about 5000 instructions for 3 rows, 13,000 for 12.
/// Threads:   pure. Allocates: nothing.
/// Source:    Kalman update with H a selection of rows. Joseph's form for unmeasured states; the columns of measured states are
///            K R, which is the same form without rounding. robot_localization, Ekf::correct.
[[nodiscard]] Result<Fused, UpdateFault> fuse(Belief& belief, const Reading& reading);
[[nodiscard]] inline Result<Updated, UpdateFault> update(const Belief& prior, const Reading& reading) {
  Updated posterior{prior, {}};
  const auto fused = fuse(posterior.belief, reading);
  if (!fused) return err(fused.error());
  posterior.fused = *fused;
  return posterior;
}

/// Whether a Cholesky factor exists, computed without allocating.
[[nodiscard]] bool is_positive_definite(const StateCovariance& covariance);

}  // namespace nacelle::ekf
