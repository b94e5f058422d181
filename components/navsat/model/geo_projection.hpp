// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "nacelle/base/result.hpp"

namespace nacelle::navsat {

/// A point beside the ellipsoid of WGS 84: positive to the north, to the east and up.
struct GeoPoint {
  double latitude_deg{}, longitude_deg{}, altitude_m{};
};

/// A zone of UTM. Number 0 stands for the polar caps (UPS).
struct UtmZone {
  int number{};
  bool north{};
  friend bool operator==(const UtmZone&, const UtmZone&) = default;
};

/// Reads the zone of a grid reference of MGRS: "31U", or a longer one; null if it is none.
[[nodiscard]] std::optional<UtmZone> read_utm_zone(std::string_view text);
/// Returns "31 north".
[[nodiscard]] std::string to_text(const UtmZone& zone);

enum class GeoFault : std::uint8_t {
  NotFinite,   ///< A NaN or an infinity.
  OutOfRange,  ///< No latitude or longitude: beyond 90 or 360 degrees.
  TooFar,      ///< The projection does not reach there.
};

/// A plane on which the robot drives: x to the (grid's) east, y to its north, z is the altitude. Units: m.
///
/// The zone of UTM is chosen once. A point beyond its border, or beyond the equator, is given in the same plane, so that the robot
/// does not jump there.
/// Threads:   any, since it does not change. Allocates: nothing.
/// Source:    Karney's GeographicLib: UTMUPS (Transverse Mercator with an error of nanometres) and LocalCartesian.
class GeoProjection {
 public:
  /// In the zone that holds the datum, or in a zone that the user chose.
  [[nodiscard]] static Result<GeoProjection, GeoFault> utm(const GeoPoint& datum,
                                                           std::optional<UtmZone> zone = std::nullopt);
  /// A plane that touches the ellipsoid at the datum. It keeps lengths near the datum, where UTM shortens them by up to 0.04 %.
  [[nodiscard]] static Result<GeoProjection, GeoFault> local(const GeoPoint& datum);

  [[nodiscard]] Result<Eigen::Vector3d, GeoFault> forward(const GeoPoint& point) const;
  /// The inverse of forward(), to a nanometre.
  [[nodiscard]] Result<GeoPoint, GeoFault> reverse(const Eigen::Vector3d& point_m) const;

  /// The y axis at the datum, clockwise from true north. Units: rad. 0 for a local plane.
  [[nodiscard]] double convergence_rad() const { return convergence_rad_; }
  /// Null for a local plane.
  [[nodiscard]] const std::optional<UtmZone>& zone() const { return zone_; }
  /// Returns whether a point's own zone of UTM is another than the datum's.
  [[nodiscard]] bool is_in_another_zone(const GeoPoint& point) const;

 private:
  explicit GeoProjection(const GeoPoint& datum) : datum_(datum) {}

  GeoPoint datum_;
  std::optional<UtmZone> zone_;
  double convergence_rad_ = 0.0;
};

/// Errors: NotFinite, OutOfRange.
[[nodiscard]] Result<void, GeoFault> check_position(double latitude_deg, double longitude_deg);

}  // namespace nacelle::navsat
