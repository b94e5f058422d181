// SPDX-License-Identifier: Apache-2.0
#include "navsat/model/geo_projection.hpp"

#include <GeographicLib/Constants.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/MGRS.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <numbers>

namespace nacelle::navsat {
namespace {

using GeographicLib::LocalCartesian;
using GeographicLib::UTMUPS;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
// A plane that touches the Earth here says little about places farther away than this, and nothing about the other side.
constexpr double kReach_m = 5e6;

struct GridPoint {
  UtmZone zone;
  double x_m{}, y_m{}, convergence_deg{};
};

/// `zone`: a number, or UTMUPS::STANDARD.
Result<GridPoint, GeoFault> to_grid(const GeoPoint& point, int zone) {
  GridPoint grid;
  double scale = 0.0;
  try {
    UTMUPS::Forward(point.latitude_deg, point.longitude_deg, grid.zone.number, grid.zone.north, grid.x_m, grid.y_m,
                    grid.convergence_deg, scale, zone);
  } catch (const GeographicLib::GeographicErr&) { return err(GeoFault::TooFar); }
  return grid;
}

/// The same northing counted from the other hemisphere's origin: the southern one has 10,000 km at the equator.
double northing_in(bool north, const GridPoint& grid) {
  if (grid.zone.north == north || grid.zone.number == UTMUPS::UPS) return grid.y_m;
  return grid.y_m + (north ? -UTMUPS::UTMShift() : UTMUPS::UTMShift());
}

}  // namespace

std::optional<UtmZone> read_utm_zone(std::string_view text) {
  UtmZone zone;
  double x_m = 0.0, y_m = 0.0;
  int precision = 0;
  try {
    GeographicLib::MGRS::Reverse(std::string(text), zone.number, zone.north, x_m, y_m, precision);
  } catch (const std::exception&) { return std::nullopt; }
  if (zone.number < UTMUPS::MINZONE || zone.number > UTMUPS::MAXZONE) return std::nullopt;
  return zone;
}

std::string to_text(const UtmZone& zone) {
  return (zone.number == UTMUPS::UPS ? std::string("polar cap") : std::to_string(zone.number)) +
         (zone.north ? " north" : " south");
}

Result<void, GeoFault> check_position(double latitude_deg, double longitude_deg) {
  if (!std::isfinite(latitude_deg) || !std::isfinite(longitude_deg)) return err(GeoFault::NotFinite);
  if (std::abs(latitude_deg) > 90.0 || std::abs(longitude_deg) > 360.0) return err(GeoFault::OutOfRange);
  return {};
}

Result<GeoProjection, GeoFault> GeoProjection::utm(const GeoPoint& datum, std::optional<UtmZone> zone) {
  if (const auto checked = check_position(datum.latitude_deg, datum.longitude_deg); !checked)
    return err(checked.error());
  const auto grid = to_grid(datum, zone ? zone->number : static_cast<int>(UTMUPS::STANDARD));
  if (!grid) return err(grid.error());
  GeoProjection projection{datum};
  projection.zone_ = grid->zone;
  projection.convergence_rad_ = grid->convergence_deg * kRadPerDeg;
  return projection;
}

Result<GeoProjection, GeoFault> GeoProjection::local(const GeoPoint& datum) {
  if (const auto checked = check_position(datum.latitude_deg, datum.longitude_deg); !checked)
    return err(checked.error());
  return GeoProjection{datum};
}

Result<Eigen::Vector3d, GeoFault> GeoProjection::forward(const GeoPoint& point) const {
  if (const auto checked = check_position(point.latitude_deg, point.longitude_deg); !checked)
    return err(checked.error());
  if (!std::isfinite(point.altitude_m)) return err(GeoFault::NotFinite);
  if (zone_) {
    const auto grid = to_grid(point, zone_->number);
    if (!grid) return err(grid.error());
    return Eigen::Vector3d{grid->x_m, northing_in(zone_->north, *grid), point.altitude_m};
  }
  const LocalCartesian plane{datum_.latitude_deg, datum_.longitude_deg, 0.0};
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;
  plane.Forward(point.latitude_deg, point.longitude_deg, point.altitude_m, x_m, y_m, z_m);
  const bool is_other_side = z_m < -kReach_m;
  if (is_other_side || std::hypot(x_m, y_m) > kReach_m) return err(GeoFault::TooFar);
  return Eigen::Vector3d{x_m, y_m, point.altitude_m};
}

Result<GeoPoint, GeoFault> GeoProjection::reverse(const Eigen::Vector3d& point_m) const {
  if (!point_m.allFinite()) return err(GeoFault::NotFinite);
  GeoPoint point{.altitude_m = point_m.z()};
  if (zone_) {
    try {
      UTMUPS::Reverse(zone_->number, zone_->north, point_m.x(), point_m.y(), point.latitude_deg, point.longitude_deg);
    } catch (const GeographicLib::GeographicErr&) { return err(GeoFault::TooFar); }
    return point;
  }
  if (point_m.head<2>().norm() > kReach_m) return err(GeoFault::TooFar);
  const LocalCartesian plane{datum_.latitude_deg, datum_.longitude_deg, 0.0};
  // z is the altitude, not the height above the plane: the point of this altitude above or below (x, y) is looked for. Each step leaves
  // the error times about 1 - cos(distance / radius of the Earth).
  double z_m = point_m.z(), altitude_m = 0.0;
  for (int step = 0; step < 60; ++step) {
    plane.Reverse(point_m.x(), point_m.y(), z_m, point.latitude_deg, point.longitude_deg, altitude_m);
    const double error_m = point_m.z() - altitude_m;
    if (std::abs(error_m) < 1e-9) break;
    z_m += error_m;
  }
  return point;
}

bool GeoProjection::is_in_another_zone(const GeoPoint& point) const {
  if (!zone_) return false;
  try {
    return UTMUPS::StandardZone(point.latitude_deg, point.longitude_deg) != zone_->number;
  } catch (const GeographicLib::GeographicErr&) { return false; }
}

}  // namespace nacelle::navsat
