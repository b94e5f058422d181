// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/gps_model.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::simulation {
namespace {

constexpr std::uint64_t kGpsStream = 6;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr std::int64_t kNoon_ms = 12 * 3'600'000, kDay_ms = 24 * 3'600'000;
// Slower than this a receiver gives no course.
constexpr double kLeastSpeed_mps = 0.05;
// WGS 84.
constexpr double kEquatorialRadius_m = 6378137.0, kEccentricity2 = 0.00669437999014;
// Better errors are those of a receiver with corrections by radio: RTK, fixed.
constexpr double kRtkError_m = 0.1;

double degrees_of_course(double yaw_rad) {
  const double course_deg = 90.0 - yaw_rad / kRadPerDeg;
  return course_deg - 360.0 * std::floor(course_deg / 360.0);
}

}  // namespace

GpsModel::GpsModel(const WorldSettings& settings) : gps_(settings.gps), draws_(settings.seed, kGpsStream) {
  // The radii of curvature at the origin: the world is so small that they hold in all of it.
  const double sine = std::sin(gps_.latitude_deg * kRadPerDeg);
  const double w = std::sqrt(1.0 - kEccentricity2 * sine * sine);
  const double height_m = gps_.above_geoid_m + gps_.geoid_m;
  const double meridian_m = kEquatorialRadius_m * (1.0 - kEccentricity2) / (w * w * w) + height_m;
  const double normal_m = kEquatorialRadius_m / w + height_m;
  metres_per_degree_north_ = meridian_m * kRadPerDeg;
  metres_per_degree_east_ = normal_m * std::cos(gps_.latitude_deg * kRadPerDeg) * kRadPerDeg;
}

GpsReading GpsModel::measure(const Pose& pose, double speed_mps, Duration now) {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const double sigma_m = gps_.hdop * gps_.error_m, sigma_up_m = gps_.vdop * gps_.error_m;
  const double east_m = pose.x_m + c * gps_.antenna_x_m - s * gps_.antenna_y_m + draws_.normal(sigma_m);
  const double north_m = pose.y_m + s * gps_.antenna_x_m + c * gps_.antenna_y_m + draws_.normal(sigma_m);
  GpsReading reading;
  reading.time_of_day_ms = (kNoon_ms + std::chrono::duration_cast<std::chrono::milliseconds>(now).count()) % kDay_ms;
  reading.quality = gps_.error_m <= kRtkError_m ? 4 : 2;
  reading.latitude_deg = gps_.latitude_deg + north_m / metres_per_degree_north_;
  reading.longitude_deg = gps_.longitude_deg + east_m / metres_per_degree_east_;
  reading.above_geoid_m = gps_.above_geoid_m + gps_.antenna_z_m + draws_.normal(sigma_up_m);
  reading.geoid_m = gps_.geoid_m;
  reading.hdop = gps_.hdop;
  reading.vdop = gps_.vdop;
  reading.pdop = std::hypot(gps_.hdop, gps_.vdop);
  reading.range_rms_m = gps_.error_m;
  reading.latitude_stddev_m = reading.longitude_stddev_m = sigma_m;
  reading.altitude_stddev_m = sigma_up_m;
  reading.speed_mps = std::abs(speed_mps);
  if (reading.speed_mps >= kLeastSpeed_mps)
    reading.course_deg = degrees_of_course(speed_mps < 0.0 ? pose.yaw_rad + std::numbers::pi : pose.yaw_rad);
  return reading;
}

}  // namespace nacelle::simulation
