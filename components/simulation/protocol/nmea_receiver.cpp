// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/nmea_receiver.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <string_view>

namespace nacelle::simulation {
namespace {

constexpr double kKnotsPerMps = 1.943844492440605;

std::string framed(const std::string& body) {
  unsigned sum = 0;
  for (const char letter : body) sum ^= static_cast<unsigned char>(letter);
  return fmt::format("${}*{:02X}\r\n", body, sum);
}

std::string utc(const GpsReading& reading) {
  const auto ms = reading.time_of_day_ms;
  return fmt::format("{:02}{:02}{:02}.{:02}", ms / 3'600'000, ms / 60'000 % 60, ms / 1000 % 60, ms / 10 % 100);
}

/// Degrees and minutes with five decimals, counted in whole steps, so that 59.999999 minutes carry into the degrees.
std::string angle(double degrees, int digits, std::string_view sides) {
  const long long steps = std::llabs(std::llround(degrees * 60e5));
  return fmt::format("{:0{}}{:02}.{:05},{}", steps / 6'000'000, digits, steps / 100'000 % 60, steps % 100'000,
                     degrees < 0 ? sides[1] : sides[0]);
}

std::string position(const GpsReading& reading) {
  if (reading.quality == 0) return ",,,";
  return angle(reading.latitude_deg, 2, "NS") + "," + angle(reading.longitude_deg, 3, "EW");
}

std::string course(const GpsReading& reading) {
  return reading.quality != 0 && reading.course_deg ? fmt::format("{:.2f}", *reading.course_deg) : "";
}

char mode(const GpsReading& reading) { return reading.quality == 0 ? 'N' : reading.quality == 1 ? 'A' : 'D'; }

}  // namespace

std::string print_rmc(const GpsReading& reading) {
  const bool fixed = reading.quality != 0;
  return framed(fmt::format("GPRMC,{},{},{},{},{},{:02}{:02}{:02},,,{}", utc(reading), fixed ? 'A' : 'V',
                            position(reading), fixed ? fmt::format("{:.3f}", reading.speed_mps * kKnotsPerMps) : "",
                            course(reading), reading.day, reading.month, reading.year % 100, mode(reading)));
}

std::string print_vtg(const GpsReading& reading) {
  if (reading.quality == 0) return framed("GPVTG,,,,,,,,,N");
  return framed(fmt::format("GPVTG,{},T,,M,{:.3f},N,{:.3f},K,{}", course(reading), reading.speed_mps * kKnotsPerMps,
                            reading.speed_mps * 3.6, mode(reading)));
}

std::string print_gga(const GpsReading& reading) {
  if (reading.quality == 0) return framed(fmt::format("GPGGA,{},,,,,0,00,99.99,,,,,,", utc(reading)));
  return framed(fmt::format("GPGGA,{},{},{},{:02},{:.2f},{:.1f},M,{:.1f},M,,", utc(reading), position(reading),
                            reading.quality, reading.satellites.size(), reading.hdop, reading.above_geoid_m,
                            reading.geoid_m));
}

std::string print_gsa(const GpsReading& reading) {
  const bool fixed = reading.quality != 0;
  std::string body = fmt::format("GPGSA,A,{}", fixed ? 3 : 1);
  for (std::size_t i = 0; i < 12; ++i)
    body += fixed && i < reading.satellites.size() ? fmt::format(",{:02}", reading.satellites[i]) : ",";
  const auto dilution = [&](double value) { return fixed ? value : 99.99; };
  return framed(body + fmt::format(",{:.2f},{:.2f},{:.2f}", dilution(reading.pdop), dilution(reading.hdop),
                                   dilution(reading.vdop)));
}

std::string print_gst(const GpsReading& reading) {
  if (reading.quality == 0) return framed(fmt::format("GPGST,{},,,,,,,", utc(reading)));
  return framed(fmt::format("GPGST,{},{:.1f},,,,{:.1f},{:.1f},{:.1f}", utc(reading), reading.range_rms_m,
                            reading.latitude_stddev_m, reading.longitude_stddev_m, reading.altitude_stddev_m));
}

std::string print_nmea_burst(const GpsReading& reading) {
  return print_rmc(reading) + print_vtg(reading) + print_gga(reading) + print_gsa(reading) + print_gst(reading);
}

}  // namespace nacelle::simulation
