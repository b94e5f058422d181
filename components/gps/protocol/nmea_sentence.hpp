// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "nacelle/base/time.hpp"

namespace nacelle::gps {

// Fields of the sentences that are read, counted from 1 behind the address. Anything may be empty.
// Source: the documents named in nmea_framer.hpp.
//
//   GGA  1 UTC hhmmss.ss   2,3 latitude ddmm.mmmm N|S   4,5 longitude dddmm.mmmm E|W   6 quality   7 satellites   8 HDOP
//        9,10 height above the geoid, M   11,12 height of the geoid above the ellipsoid, M
//   RMC  1 UTC   2 A valid, V not   3,4 latitude   5,6 longitude   7 speed, knots   8 course over ground, deg from north   9 date ddmmyy
//   GSA  1 M|A   2 fix 1 none, 2 2D, 3 3D   3..14 satellites   15 PDOP   16 HDOP   17 VDOP
//   GST  1 UTC   2 RMS of the ranges   3,4,5 error ellipse   6,7,8 standard deviation of latitude, longitude and height, m
//   VTG  1,2 course, deg from true north, T   3,4 from magnetic north, M   5,6 speed, knots, N   7,8 speed, km/h, K

/// Degrees on the ellipsoid of WGS 84, positive to the north and to the east.
struct GeoPosition {
  double latitude_deg{}, longitude_deg{};
  friend bool operator==(const GeoPosition&, const GeoPosition&) = default;
};

/// Fix data. Quality: 0 none, 1 autonomous, 2 differential (SBAS), 3 PPS, 4 RTK fixed, 5 RTK float, 6 dead reckoning, 7 set by hand,
/// 8 simulated, 9 WAAS (NovAtel).
struct Gga {
  std::optional<Duration> utc{};  ///< Since midnight.
  std::optional<GeoPosition> position{};
  std::uint8_t quality{};
  std::optional<double> hdop{};
  std::optional<double> above_geoid_m{};
  std::optional<double> geoid_m{};  ///< Above the ellipsoid.
};

struct CalendarDate {
  int year{}, month{}, day{};
  friend bool operator==(const CalendarDate&, const CalendarDate&) = default;
};

/// Position, velocity and time.
struct Rmc {
  std::optional<Duration> utc{};
  bool valid{};
  std::optional<GeoPosition> position{};
  std::optional<double> speed_mps{};
  std::optional<double> course_deg{};  ///< Clockwise from true north.
  std::optional<CalendarDate> date{};
};

/// Dilution of precision.
struct Gsa {
  std::uint8_t fix{};
  std::optional<double> pdop{}, hdop{}, vdop{};
};

/// The receiver's own estimate of its errors.
struct Gst {
  std::optional<Duration> utc{};
  std::optional<double> latitude_stddev_m{}, longitude_stddev_m{}, altitude_stddev_m{};
};

/// Velocity over ground.
struct Vtg {
  std::optional<double> course_deg{};  ///< Clockwise from true north.
  std::optional<double> speed_mps{};
};

/// A sentence of another kind: satellites in view, a company's own, and so on.
struct OtherSentence {};
/// A sentence of a known kind with a field that cannot be.
struct MalformedSentence {};

using NmeaMessage = std::variant<OtherSentence, MalformedSentence, Gga, Rmc, Gsa, Gst, Vtg>;

/// Reads the text between `$` and `*`. Allocates: nothing.
[[nodiscard]] NmeaMessage read_nmea(std::string_view text);

/// Returns "GP" of "GPGGA,...".
[[nodiscard]] std::string_view talker_of(std::string_view text);

}  // namespace nacelle::gps
