// SPDX-License-Identifier: Apache-2.0
// Any numbers as a datum and a fix, any text as a zone: nothing crashes, what is taken is finite, and what goes forward comes back.
//
//   offset  bytes  field
//        0      1  bit 0: a local plane, bit 1: the altitude does not count, bit 2: a zone is chosen
//        1     48  datum and fix: latitude, longitude, altitude, as doubles
//       49      8  a variance
//       57      -  the zone's text
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "navsat/model/fix_check.hpp"

namespace {

using namespace nacelle::navsat;

void require(bool holds) {
  if (!holds) std::abort();
}

/// Farther away a projection bends too much to be turned back exactly, and a robot does not drive there.
bool is_near(const GeoPoint& a, const GeoPoint& b) {
  return std::abs(a.latitude_deg - b.latitude_deg) < 1.0 && std::abs(a.longitude_deg - b.longitude_deg) < 1.0 &&
         std::abs(a.altitude_m) < 1e5 && std::abs(a.latitude_deg) < 89.0;
}

void require_return(const GeoProjection& projection, const GeoPoint& datum, const GeoPoint& point) {
  static_cast<void>(projection.is_in_another_zone(point));
  const auto p = projection.forward(point);
  if (!p) return;
  require(p->allFinite());
  const auto back = projection.reverse(*p);
  if (!is_near(point, datum)) return;
  require(back.has_value());
  require(std::abs(back->latitude_deg - point.latitude_deg) < 1e-9);
  require(std::abs(std::remainder(back->longitude_deg - point.longitude_deg, 360.0)) < 1e-7);
  require(std::abs(back->altitude_m - point.altitude_m) < 1e-6);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 57) return 0;
  std::array<double, 7> numbers{};
  std::memcpy(numbers.data(), data + 1, sizeof numbers);
  const std::string_view text{reinterpret_cast<const char*>(data + 57), size - 57};
  const auto zone = read_utm_zone(text);
  if (zone) require(zone->number >= 0 && zone->number <= 60 && !to_text(*zone).empty());

  FixReading reading{.has_fix = true, .point = {numbers[3], numbers[4], numbers[5]}, .has_covariance = true};
  reading.covariance_m2.diagonal().setConstant(numbers[6]);
  const auto fix = check_fix(reading, {.ignores_altitude = (data[0] & 2U) != 0});
  if (!fix) {
    require(*explain(fix.error()) != '\0');
    return 0;
  }
  require(fix->covariance_m2.allFinite() && fix->covariance_m2(0, 0) > 0.0);
  const GeoPoint datum{numbers[0], numbers[1], numbers[2]};
  const auto projection = (data[0] & 1U) != 0 ? GeoProjection::local(datum)
                                              : GeoProjection::utm(datum, (data[0] & 4U) != 0 ? zone : std::nullopt);
  if (!projection) return 0;
  require(std::isfinite(projection->convergence_rad()));
  require_return(*projection, datum, fix->point);
  return 0;
}
