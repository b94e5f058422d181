// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nacelle::simulation {

/// What a GPS receiver knows at one moment.
struct GpsReading {
  std::int64_t time_of_day_ms = 0;  ///< UTC, since midnight.
  int day = 1, month = 1, year = 2025;
  int quality = 1;  ///< As in GGA: 0 none, 1 autonomous, 2 SBAS, 4 RTK fixed, 5 RTK float.
  double latitude_deg{}, longitude_deg{};
  double above_geoid_m{}, geoid_m{};
  std::vector<int> satellites{2, 5, 7, 13, 15, 20, 29, 30};  ///< Used; 12 of them at the most are listed.
  double pdop = 1.94, hdop = 1.18, vdop = 1.54;
  double range_rms_m = 1.8, latitude_stddev_m = 1.7, longitude_stddev_m = 1.3, altitude_stddev_m = 2.2;
  double speed_mps{};
  std::optional<double> course_deg{};  ///< Clockwise from north; a receiver at rest has none.
};

// The sentences of a u-blox receiver, with `$`, checksum, CR and LF. Without a fix the fields of the position are empty.
// Source: u-blox 7 Receiver Description Including Protocol Specification, chapter NMEA.
[[nodiscard]] std::string print_rmc(const GpsReading& reading);
[[nodiscard]] std::string print_vtg(const GpsReading& reading);
[[nodiscard]] std::string print_gga(const GpsReading& reading);
[[nodiscard]] std::string print_gsa(const GpsReading& reading);
[[nodiscard]] std::string print_gst(const GpsReading& reading);
/// All of them, in the receiver's order.
[[nodiscard]] std::string print_nmea_burst(const GpsReading& reading);

}  // namespace nacelle::simulation
