// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/gps_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gps/protocol/nmea_framer.hpp"
#include "gps/protocol/nmea_sentence.hpp"
#include "simulation/component/run_device.hpp"
#include "simulation/model/world_model.hpp"

namespace nacelle::simulation {
namespace {

// Of a degree at the world's origin. Source: WGS 84's radii of curvature, rounded.
constexpr double kMetresNorth = 111'239.0, kMetresEast = 71'877.0;

TEST(GpsModel, its_errors_are_its_hdop_times_that_of_the_ranges) {
  WorldSettings settings{.seed = 3};
  settings.gps.error_m = 2.0;
  settings.gps.hdop = 1.5;
  settings.gps.vdop = 3.0;
  GpsModel gps{settings};
  double sum_m = 0.0, sum2_m2 = 0.0, sum_up2_m2 = 0.0;
  constexpr int kFixes = 4000;
  for (int i = 0; i < kFixes; ++i) {
    const GpsReading reading = gps.measure({0.1, 0.0, 0.0}, 0.0, i * gps.period());
    const double north_m = (reading.latitude_deg - settings.gps.latitude_deg) * kMetresNorth;
    sum_m += north_m;
    sum2_m2 += north_m * north_m;
    const double up_m = reading.above_geoid_m - settings.gps.above_geoid_m - settings.gps.antenna_z_m;
    sum_up2_m2 += up_m * up_m;
    EXPECT_EQ(reading.hdop, 1.5);
    EXPECT_EQ(reading.latitude_stddev_m, 3.0) << "it says so in GST";
  }
  EXPECT_NEAR(sum_m / kFixes, 0.0, 0.2);
  EXPECT_NEAR(std::sqrt(sum2_m2 / kFixes), 3.0, 0.12);
  EXPECT_NEAR(std::sqrt(sum_up2_m2 / kFixes), 6.0, 0.25);
}

TEST(GpsModel, it_is_where_the_antenna_is) {
  WorldSettings settings;
  settings.gps.error_m = 0.0;
  settings.gps.antenna_x_m = 0.5;
  settings.gps.antenna_y_m = 0.2;
  GpsModel gps{settings};
  // At (3, 4) the base looks north: the antenna is 0.5 m to its north and 0.2 m to its west.
  const GpsReading reading = gps.measure({3.0, 4.0, M_PI / 2.0}, 0.3, 0s);
  EXPECT_NEAR((reading.longitude_deg - settings.gps.longitude_deg) * kMetresEast, 2.8, 0.001);
  EXPECT_NEAR((reading.latitude_deg - settings.gps.latitude_deg) * kMetresNorth, 4.5, 0.001);
  EXPECT_EQ(reading.quality, 4) << "as good as with corrections";
  ASSERT_TRUE(reading.course_deg);
  EXPECT_NEAR(*reading.course_deg, 0.0, 1e-9) << "north";
  EXPECT_NEAR(*gps.measure({0.0, 0.0, 0.0}, 0.3, 0s).course_deg, 90.0, 1e-9) << "east";
  EXPECT_NEAR(*gps.measure({0.0, 0.0, 0.0}, -0.3, 0s).course_deg, 270.0, 1e-9) << "backwards";
  EXPECT_FALSE(gps.measure({}, 0.0, 0s).course_deg) << "at rest";
}

TEST(GpsModel, the_worlds_receiver_sends_five_bursts_a_second) {
  WorldModel world{{.seed = 2}};
  gps::NmeaFramer framer;
  int fixes = 0, estimates = 0;
  while (world.now() < 10s) {
    world.step([&](Device device, ByteView bytes) {
      if (device != Device::Gps) return;
      framer.feed(bytes, {}, [&](const gps::NmeaSentence& sentence) {
        const auto message = gps::read_nmea(sentence.text);
        if (const auto* const gga = std::get_if<gps::Gga>(&message)) {
          ++fixes;
          EXPECT_NEAR(gga->position->latitude_deg, world.settings().gps.latitude_deg, 1e-4);
        }
        estimates += std::holds_alternative<gps::Gst>(message);
      });
    });
  }
  EXPECT_NEAR(fixes, 50, 1);
  EXPECT_NEAR(estimates, 50, 1);
  EXPECT_EQ(framer.stats().skipped_bytes, 0U);
  EXPECT_EQ(framer.stats().bad_checksums, 0U);
}

TEST(NmeaGps, runs_by_itself) {
  const auto device = make_device("nmea_gps", 7);
  ASSERT_TRUE(device);
  gps::NmeaFramer framer;
  int fixes = 0;
  device->advance(2s, [&](Duration, ByteView bytes) {
    framer.feed(bytes, {}, [&](const gps::NmeaSentence& sentence) {
      fixes += std::holds_alternative<gps::Gga>(gps::read_nmea(sentence.text));
    });
  });
  EXPECT_EQ(fixes, 11) << "from 0 to 2 s";
  EXPECT_GE(device->baud(), 38400U);
}

}  // namespace
}  // namespace nacelle::simulation
