// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/nmea_receiver.hpp"

#include <gtest/gtest.h>

namespace nacelle::simulation {
namespace {

constexpr std::int64_t time_ms(int hours, int minutes, int seconds) {
  return ((hours * 60LL + minutes) * 60 + seconds) * 1000;
}

// The examples of the u-blox 7 Receiver Description Including Protocol Specification, chapter NMEA.
TEST(NmeaReceiver, prints_the_examples_of_the_protocol_specification) {
  GpsReading reading;
  reading.time_of_day_ms = time_ms(9, 27, 25);
  reading.latitude_deg = 47.0 + 17.11399 / 60.0;
  reading.longitude_deg = 8.0 + 33.91590 / 60.0;
  reading.hdop = 1.01;
  reading.above_geoid_m = 499.6;
  reading.geoid_m = 48.0;
  EXPECT_EQ(print_gga(reading), "$GPGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.01,499.6,M,48.0,M,,*5B\r\n");

  reading.satellites = {23, 29, 7, 8, 9, 18, 26, 28};
  reading.hdop = 1.18;
  EXPECT_EQ(print_gsa(reading), "$GPGSA,A,3,23,29,07,08,09,18,26,28,,,,,1.94,1.18,1.54*0D\r\n");

  reading.time_of_day_ms = time_ms(8, 35, 59);
  reading.latitude_deg = 47.0 + 17.11437 / 60.0;
  reading.longitude_deg = 8.0 + 33.91522 / 60.0;
  reading.day = 9;
  reading.month = 12;
  reading.year = 2002;
  reading.speed_mps = 0.004 * 1852.0 / 3600.0;
  reading.course_deg = 77.52;
  EXPECT_EQ(print_rmc(reading), "$GPRMC,083559.00,A,4717.11437,N,00833.91522,E,0.004,77.52,091202,,,A*57\r\n");
  reading.speed_mps = 0.0021;
  EXPECT_EQ(print_vtg(reading), "$GPVTG,77.52,T,,M,0.004,N,0.008,K,A*06\r\n");

  reading.time_of_day_ms = time_ms(8, 23, 56);
  EXPECT_EQ(print_gst(reading), "$GPGST,082356.00,1.8,,,,1.7,1.3,2.2*7E\r\n");
}

TEST(NmeaReceiver, carries_minutes_into_degrees) {
  GpsReading reading;
  reading.latitude_deg = -(46.0 + 59.9999999 / 60.0);
  reading.longitude_deg = -1e-8;
  EXPECT_NE(print_gga(reading).find(",4700.00000,S,00000.00000,W,"), std::string::npos) << print_gga(reading);
}

TEST(NmeaReceiver, leaves_the_position_empty_without_a_fix) {
  GpsReading reading;
  reading.quality = 0;
  EXPECT_NE(print_gga(reading).find("$GPGGA,000000.00,,,,,0,00,99.99,,,,,,*"), std::string::npos);
  EXPECT_NE(print_rmc(reading).find(",V,,,,,,,010125,,,N*"), std::string::npos) << print_rmc(reading);
}

}  // namespace
}  // namespace nacelle::simulation
