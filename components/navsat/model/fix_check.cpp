// SPDX-License-Identifier: Apache-2.0
#include "navsat/model/fix_check.hpp"

#include <cmath>

namespace nacelle::navsat {
namespace {

/// A variance of 0 would be a claim that no receiver can keep, and a filter that believes it jumps.
bool is_usable(const Eigen::Matrix3d& covariance, bool without_altitude) {
  if (!covariance.allFinite()) return false;
  return covariance(0, 0) > 0.0 && covariance(1, 1) > 0.0 && (without_altitude || covariance(2, 2) > 0.0);
}

}  // namespace

const char* explain(Refusal refusal) {
  switch (refusal) {
    case Refusal::NoFix: return "the receiver has no fix";
    case Refusal::NotFinite: return "a value is not finite";
    case Refusal::OutOfRange: return "its latitude or longitude is out of range";
    case Refusal::TooFar: return "it is too far away from the datum";
    case Refusal::NoFrame: return "header.frame_id or child_frame_id is empty";
    case Refusal::NoOrientation: return "it has no orientation; nacelle_imu_filter computes one from imu/data_raw";
    case Refusal::UnknownHeading:
      return "its heading is unknown (variance of pi^2/3 or more): a magnetometer is needed";
  }
  return "";
}

Refusal refusal_of(GeoFault fault) {
  switch (fault) {
    case GeoFault::NotFinite: return Refusal::NotFinite;
    case GeoFault::OutOfRange: return Refusal::OutOfRange;
    case GeoFault::TooFar: return Refusal::TooFar;
  }
  return Refusal::TooFar;
}

Result<CheckedFix, Refusal> check_fix(const FixReading& reading, const FixRules& rules) {
  if (!reading.has_fix) return err(Refusal::NoFix);
  CheckedFix fix{.point = reading.point, .covariance_m2 = reading.covariance_m2};
  if (rules.ignores_altitude && !std::isfinite(fix.point.altitude_m)) fix.point.altitude_m = 0.0;
  if (!std::isfinite(fix.point.altitude_m)) return err(Refusal::NotFinite);
  if (const auto checked = check_position(fix.point.latitude_deg, fix.point.longitude_deg); !checked)
    return err(refusal_of(checked.error()));
  if (!reading.has_covariance || !is_usable(reading.covariance_m2, rules.ignores_altitude)) {
    fix.covariance_was_unknown = true;
    const double variance_m2 = rules.stddev_if_unknown_m * rules.stddev_if_unknown_m;
    fix.covariance_m2 = Eigen::Vector3d{variance_m2, variance_m2, 4.0 * variance_m2}.asDiagonal();
  }
  return fix;
}

Result<Eigen::Quaterniond, Refusal> check_orientation(const Eigen::Quaterniond& orientation,
                                                      const std::array<double, 9>& covariance) {
  if (covariance[0] == -1.0) return err(Refusal::NoOrientation);
  if (!orientation.coeffs().allFinite()) return err(Refusal::NotFinite);
  const double norm = orientation.norm();
  if (std::abs(norm - 1.0) > 0.1) return err(Refusal::NoOrientation);
  // A little less than pi^2/3: it was rounded on its way.
  if (covariance[8] >= 0.999 * kUnknownHeadingVariance) return err(Refusal::UnknownHeading);
  return Eigen::Quaterniond{orientation.coeffs() / norm};
}

}  // namespace nacelle::navsat
