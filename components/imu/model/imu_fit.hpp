// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "imu/model/sample_correction.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::imu {

/// Why measurements are no calibration.
enum class FitFault : std::uint8_t {
  TooFew,       ///< Fewer measurements than unknowns.
  NotCovered,   ///< The sensor was not turned into enough directions.
  NoEllipsoid,  ///< The measurements do not lie on one: disturbed, or the sensor moved meanwhile.
  Absurd        ///< They do, but a scale is off by more than a third: another unit, or the wrong data.
};

/// A correction c = matrix (v - bias), and how well it fits.
struct VectorFit {
  Vector3 bias{};
  Matrix3 matrix = kIdentity3;
  double length = 0.0;     ///< Of every vector after the correction.
  double rms_error = 0.0;  ///< Of that length, over the measurements.
  bool is_flat = false;    ///< Fitted in the xy plane only: the sensor was turned about z only.
};

/// Bias and scale of an accelerometer from its mean readings at rest, in at least six positions: each axis once up and once down,
/// not exactly. The correction is diagonal.
///
/// Source: at rest every reading has the length of gravity: the ellipsoid with axes along the sensor's, by linear least squares.
[[nodiscard]] Result<VectorFit, FitFault> fit_acceleration(const std::vector<Vector3>& at_rest, double gravity_mps2);

/// Hard and soft iron of a magnetometer that was turned into all directions, or about z only (then in the plane of x and y). Keeps the
/// mean length of the field.
///
/// Source: the ellipsoid v'Av + 2b'v = 1 by linear least squares; the correction is the symmetric root of A.
[[nodiscard]] Result<VectorFit, FitFault> fit_field(const std::vector<Vector3>& readings);

/// The bias and matrix of one correction that does what `first` and then, in a frame that is turned by `R_FS`, `then` do.
struct AffineCorrection {
  Vector3 bias{};
  Matrix3 matrix = kIdentity3;
};
/// Readings of a device that already corrects (c = R_FS M (v - b)) were fitted (c' = M2 (c - b2)): returns the b and M for the device that give
/// c' turned back and forth.
[[nodiscard]] AffineCorrection composed(const AffineCorrection& now, const Vector3& mounting_rpy_rad,
                                        const VectorFit& fit);

/// v in the sensor's axes. `in_frame`: in the published frame.
[[nodiscard]] Vector3 in_sensor_axes(const Vector3& in_frame, const Vector3& mounting_rpy_rad);

}  // namespace nacelle::imu
