// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "calibration_commands/model/wheel_path.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::calibration {

/// What was measured of a way.
enum class Measured : std::uint8_t {
  Distance,  ///< How far its end is from its beginning: x_m.
  Position,  ///< Where it has ended: x_m and y_m.
  Pose       ///< And which way the base looks then: yaw_rad.
};

/// A way that a base drove, by its wheels and as measured. Frame: the base at the beginning.
struct DrivenWay {
  WheelPath path;
  Measured what = Measured::Position;
  double x_m = 0.0, y_m = 0.0, yaw_rad = 0.0;
};

/// Standard deviations of the measurements.
struct MeasurementNoise {
  double position_m = 0.003, yaw_rad = 0.002;
};

/// What ways say about a base.
struct BaseEstimate {
  BaseGeometry base;
  /// Standard deviations of the multipliers, relative.
  double left_stddev = 0.0, right_stddev = 0.0, separation_stddev = 0.0;
  std::optional<SlipNoise> slip;  ///< Nothing: too few measurements to tell a noise.
  double rms_before_m = 0.0,
         rms_after_m = 0.0;  ///< Of the ends, wheels against measurement, with the old and the new base.
};

/// Why ways are no calibration.
enum class EstimateFault : std::uint8_t {
  TooFew,         ///< Fewer measured numbers than unknowns.
  NotSeen,        ///< The ways do not show radii and separation apart.
  Contradictory,  ///< With the best base the ends are off by more than 5 % of the ways: mixed-up answers, or a wheel slipped.
  Absurd          ///< A multiplier would change by more than a factor of two.
};

/// So many measured numbers more than unknowns tell a noise.
inline constexpr int kLeastExcess = 6;

/// Estimates both radii, the separation and the noise of the wheels from ways; `start` is where the search begins, `believed` what
/// the base has now.
///
/// Nonlinear least squares on the integrated readings of the wheels. Each way is weighted by the covariance that the slip gives at its
/// end, plus that of the measurement. The slip is the one for which chi-squared equals the degrees of freedom: where poses were
/// measured, its parts from the lengths and the headings of the straight ways and from the headings of the turns; else one factor for
/// all parts.
///
/// Source: Gauss-Newton; chi-squared by its expectation (method of moments). Allocates: yes. Threads: pure.
[[nodiscard]] Result<BaseEstimate, EstimateFault> estimate_base(const BaseGeometry& believed, const BaseGeometry& start,
                                                                const std::vector<DrivenWay>& ways,
                                                                const MeasurementNoise& measurement);

}  // namespace nacelle::calibration
