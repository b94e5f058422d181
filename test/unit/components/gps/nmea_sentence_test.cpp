// SPDX-License-Identifier: Apache-2.0
#include "gps/protocol/nmea_sentence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "simulation/protocol/nmea_receiver.hpp"

namespace nacelle::gps {
namespace {

template <typename Message>
Message read_as(std::string_view text) {
  const NmeaMessage read = read_nmea(text);
  EXPECT_TRUE(std::holds_alternative<Message>(read)) << text;
  return std::holds_alternative<Message>(read) ? std::get<Message>(read) : Message{};
}

// A receiver's epoch with gpsd's reading of it: gpsd 3.20, test/daemon/polarx2.log.chk.
TEST(NmeaSentence, reads_what_gpsd_reads) {
  const auto gst = read_as<Gst>("GPGST,112257.00,0.387,317.719,3.872,1.791,317.563,10.659,180.746");
  EXPECT_EQ(gst.latitude_stddev_m, 317.563);
  EXPECT_EQ(gst.longitude_stddev_m, 10.659);
  EXPECT_EQ(gst.altitude_stddev_m, 180.746);
  EXPECT_EQ(gst.utc, 11h + 22min + 57s);

  const auto gga = read_as<Gga>("GPGGA,112257.00,3844.24011,N,00908.43828,W,1,03,10.5,,,,,,");
  ASSERT_TRUE(gga.position);
  EXPECT_NEAR(gga.position->latitude_deg, 38.737335167, 5e-10);
  EXPECT_NEAR(gga.position->longitude_deg, -9.140638000, 5e-10);
  EXPECT_EQ(gga.quality, 1);
  EXPECT_EQ(gga.hdop, 10.5);
  EXPECT_FALSE(gga.above_geoid_m);

  const auto rmc = read_as<Rmc>("GPRMC,112257.00,A,3844.24011,N,00908.43828,W,0.1,339.1,220312,5.6,E,A");
  EXPECT_TRUE(rmc.valid);
  EXPECT_EQ(rmc.position, gga.position);
  ASSERT_TRUE(rmc.speed_mps);
  EXPECT_NEAR(*rmc.speed_mps, 0.051, 5e-4);
  EXPECT_EQ(rmc.course_deg, 339.1);
  EXPECT_EQ(rmc.date, (CalendarDate{2012, 3, 22}));

  const auto vtg = read_as<Vtg>("GPVTG,339.1,T,333.5,M,0.1,N,0.1,K,A");
  EXPECT_EQ(vtg.course_deg, 339.1);
  EXPECT_NEAR(vtg.speed_mps.value_or(0.0), 0.051, 5e-4);

  const auto gsa = read_as<Gsa>("GPGSA,A,2,10,13,23,,,,,,,,,,10.5,10.5,");
  EXPECT_EQ(gsa.fix, 2);
  EXPECT_EQ(gsa.hdop, 10.5);
  EXPECT_FALSE(gsa.vdop);
}

// Wikipedia, "NMEA 0183", sample file.
TEST(NmeaSentence, reads_four_decimals_and_a_geoid) {
  const auto gga = read_as<Gga>("GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M,55.2,M,,");
  ASSERT_TRUE(gga.position);
  EXPECT_NEAR(gga.position->latitude_deg, 53.0 + 21.6802 / 60.0, 1e-12);
  EXPECT_NEAR(gga.position->longitude_deg, -(6.0 + 30.3372 / 60.0), 1e-12);
  EXPECT_EQ(gga.above_geoid_m, 61.7);
  EXPECT_EQ(gga.geoid_m, 55.2);
  const auto gsa = read_as<Gsa>("GPGSA,A,3,10,07,05,02,29,04,08,13,,,,,1.72,1.03,1.38");
  EXPECT_EQ(gsa.vdop, 1.38);
}

// gpsinformation.org, "NMEA data": the oldest form, without decimals of seconds.
TEST(NmeaSentence, reads_a_receiver_of_the_nineties) {
  const auto rmc = read_as<Rmc>("GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W");
  EXPECT_EQ(rmc.date, (CalendarDate{1994, 3, 23}));
  EXPECT_EQ(rmc.utc, 12h + 35min + 19s);
  EXPECT_NEAR(rmc.speed_mps.value_or(0.0), 22.4 * 1852.0 / 3600.0, 1e-9);
  EXPECT_EQ(rmc.course_deg, 84.4);
}

// os.mbed.com, MODGPS, info.h: a receiver that has lost its satellites.
TEST(NmeaSentence, reads_a_receiver_without_a_fix) {
  const auto gga = read_as<Gga>("GPGGA,075851.891,5611.5305,N,00302.0369,W,0,00,4.8,44.0,M,52.0,M,,0000");
  EXPECT_EQ(gga.quality, 0);
  const auto rmc = read_as<Rmc>("GPRMC,075851.891,V,5611.5305,N,00302.0369,W,002.2,252.9,160411,,,N");
  EXPECT_FALSE(rmc.valid);
  const auto empty = read_as<Gga>("GPGGA,,,,,,0,,,,,,,,");
  EXPECT_FALSE(empty.utc);
  EXPECT_FALSE(empty.position);
}

TEST(NmeaSentence, leaves_other_sentences_alone) {
  for (const char* text :
       {"GPGSV,3,1,12,20,82,116,", "PGRMC,A,3,20", "PUBX,00,081350.00", "GPGG", "", "GPGGAX,1", ",,,"})
    EXPECT_TRUE(std::holds_alternative<OtherSentence>(read_nmea(text))) << text;
}

TEST(NmeaSentence, refuses_a_field_that_cannot_be) {
  for (const char* text : {"GPGGA,252750.00,,,,,1,8,1.0,1.0,M,1.0,M,,", "GPGGA,096050.00,,,,,1,8,1.0,1.0,M,1.0,M,,",
                           "GPGGA,092750.00,9000.001,N,00630.3372,W,1,8,1.0,1,M,1,M,,",
                           "GPGGA,092750.00,5360.000,N,00630.3372,W,1,8,1.0,1,M,1,M,,",
                           "GPGGA,092750.00,5321.6802,E,00630.3372,W,1,8,1.0,1,M,1,M,,",
                           "GPGGA,092750.00,5321.6802,N,18000.0001,W,1,8,1.0,1,M,1,M,,",
                           "GPGGA,092750.00,5321.6802,N,00630.3372,W,X,8,1.0,1,M,1,M,,",
                           "GPGGA,092750.00,5321.6802,N,00630.3372,W,1,8,nan,1,M,1,M,,",
                           "GPGGA,092750.00,5321.6802,N,00630.3372,W,1,8,1.0,1,F,1,M,,",
                           "GPGGA,092750.00,53e1,N,00630.3372,W,1,8,1.0,1,M,1,M,,",
                           "GPRMC,123519,X,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W",
                           "GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,310299,003.1,W",
                           "GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,-30294,003.1,W",
                           "GPGST,112257.00,0.387,,,,-1.0,10.659,180.746", "GPVTG,339.1x,T,333.5,M,0.1,N,0.1,K,A"})
    EXPECT_TRUE(std::holds_alternative<MalformedSentence>(read_nmea(text))) << text;
}

TEST(NmeaSentence, reads_what_a_receiver_prints) {
  constexpr unsigned kSeed = 23;
  std::mt19937 random{kSeed};
  std::uniform_real_distribution<double> unit{-1.0, 1.0};
  for (int round = 0; round < 2000; ++round) {
    simulation::GpsReading reading;
    reading.time_of_day_ms = static_cast<std::int64_t>(random() % 8'640'000) * 10;
    reading.latitude_deg = 90.0 * unit(random);
    reading.longitude_deg = 180.0 * unit(random);
    const std::string line = simulation::print_gga(reading);
    const auto gga = read_as<Gga>(std::string_view{line}.substr(1, line.size() - 6));
    ASSERT_TRUE(gga.position) << line;
    // The last of five decimals of a minute is 1.9 cm.
    EXPECT_NEAR(gga.position->latitude_deg, reading.latitude_deg, 0.51e-5 / 60.0) << line;
    EXPECT_NEAR(gga.position->longitude_deg, reading.longitude_deg, 0.51e-5 / 60.0) << line;
    EXPECT_EQ(gga.utc, std::chrono::milliseconds{reading.time_of_day_ms}) << line;
  }
}

}  // namespace
}  // namespace nacelle::gps
