// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>

#include "nacelle/base/result.hpp"
#include "navsat/model/geo_projection.hpp"

namespace nacelle::navsat {

/// Why a message is not used.
enum class Refusal : std::uint8_t {
  NoFix,           ///< The receiver says that it has none.
  NotFinite,       ///< A NaN or an infinity.
  OutOfRange,      ///< No latitude or longitude.
  TooFar,          ///< The projection of the datum does not reach there.
  NoFrame,         ///< An odometry without frames, which are the robot's.
  NoOrientation,   ///< An IMU that says it measures none, or an orientation that is none.
  UnknownHeading,  ///< The variance of the heading is that of an angle which may be anything.
};
inline constexpr std::size_t kRefusals = 7;
/// "no_fix", ...: keys in /diagnostics.
inline constexpr std::array<const char*, kRefusals> kRefusalNames{
    "no_fix", "not_finite", "out_of_range", "too_far", "no_frame", "no_orientation", "unknown_heading"};
/// What a log says of it.
[[nodiscard]] const char* explain(Refusal refusal);
[[nodiscard]] Refusal refusal_of(GeoFault fault);

using Refusals = std::array<std::uint64_t, kRefusals>;

/// What a message NavSatFix says.
struct FixReading {
  bool has_fix{};
  GeoPoint point{};
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< East, north, up.
  bool has_covariance{};                                    ///< The message says that it knows one.
};

struct FixRules {
  bool ignores_altitude{};           ///< An altitude that is not a number counts as 0.
  double stddev_if_unknown_m = 4.0;  ///< Horizontal, of a fix without a usable covariance; twice that up.
};

/// A fix that can be used.
struct CheckedFix {
  GeoPoint point{};
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  bool covariance_was_unknown{};  ///< The rules gave it.
};

/// Errors: NoFix, NotFinite, OutOfRange.
[[nodiscard]] Result<CheckedFix, Refusal> check_fix(const FixReading& reading, const FixRules& rules);

/// Of an orientation about the vertical axis, uniform over the circle: pi^2 / 3. Units: rad^2.
inline constexpr double kUnknownHeadingVariance = 3.2898681336964524;

/// Returns R_EB of an orientation that can be a heading. `covariance`: of the message; its first number is -1 if nothing is measured.
/// Errors: NoOrientation, NotFinite, UnknownHeading.
[[nodiscard]] Result<Eigen::Quaterniond, Refusal> check_orientation(const Eigen::Quaterniond& orientation,
                                                                    const std::array<double, 9>& covariance);

}  // namespace nacelle::navsat
