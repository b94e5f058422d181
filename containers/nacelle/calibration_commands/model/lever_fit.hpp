// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nacelle/base/result.hpp"

namespace nacelle::calibration {

/// A reading of an IMU, turned into the axes that the base is believed to have. The rate's bias is taken off; the acceleration's is
/// not.
struct PlanarReading {
  double stamp_s = 0.0;
  double yaw_rate_rps = 0.0;
  double x_mps2 = 0.0, y_mps2 = 0.0;  ///< Specific force.
};

/// How far a base has come, by its wheels.
struct Progress {
  double stamp_s = 0.0;
  double distance_m = 0.0, yaw_rad = 0.0;
};

/// How an IMU sits on a base.
struct LeverFit {
  double yaw_rad = 0.0;         ///< Of the IMU's axes in the base; beyond what is believed.
  double x_m = 0.0, y_m = 0.0;  ///< The lever arm: the IMU as seen from the middle of the axle, along the base's axes.
  double yaw_stddev_rad = 0.0, x_stddev_m = 0.0, y_stddev_m = 0.0;
  /// Length of the accelerations that were measured over that of the wheels'. The wheels' noise makes it less than one.
  double scale = 1.0;
  double rms_mps2 = 0.0;    ///< What is left of the accelerations.
  std::size_t windows = 0;  ///< That it was found from.

  /// Whether the standard deviations are at most half of what a calibration should reach: 0.25 degrees and 5 mm.
  [[nodiscard]] bool is_sure() const;
};

/// Why a drive does not show how an IMU sits.
enum class LeverFault : std::uint8_t {
  TooFew,         ///< Less than 8 s of readings of both without gaps.
  GyroDisagrees,  ///< Gyro and wheels differ by more than 30 %, or in sign.
  HardlyTurned,   ///< Less than one turn, or slower than 0.3 rad/s.
  OneWay,         ///< Turned one way only: the pull inwards cannot be told from a lever arm to the side.
  HardlyDriven,   ///< The wheels' accelerations are below 0.05 m/s^2: no direction to compare with.
  Mismatch        ///< The accelerations that were measured are not those of the wheels.
};

/// Finds the mounting yaw and the lever arm of an IMU from a drive on a level floor.
///
/// A rigid body moves its point at r with a_r = a_base + alpha x r + w x (w x r). In the plane, with v and v' of the wheels, w and alpha = w'
/// of the gyro, R the mounting yaw, f the specific force and b its bias and what the floor's tilt adds:
///   f = R^T (v' - alpha r_y - w^2 r_x,  v w + alpha r_x - w^2 r_y) + b
/// R^T commutes with turns by 90 degrees, so f is linear in (cos, sin, R^T r, b): six unknowns, linear least squares. Each equation is
/// the mean over a window of 0.5 s, where the mean of a derivative is a difference: nothing is differentiated but the wheels' way.
/// Windows that are off by more than four standard deviations of most of them, bumps of the floor, are left out.
///
/// The height of the IMU and its mounting roll and pitch do not show in the plane.
/// Source: rigid body kinematics, e.g. Featherstone, "Rigid Body Dynamics Algorithms" (2008), sec. 2.8; docs/ekf.md.
/// Threads: pure. Allocates: yes.
[[nodiscard]] Result<LeverFit, LeverFault> fit_lever(const std::vector<PlanarReading>& readings,
                                                     const std::vector<Progress>& wheels);

}  // namespace nacelle::calibration
