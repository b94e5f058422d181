// SPDX-License-Identifier: Apache-2.0
#include "navsat/model/fix_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace nacelle::navsat {
namespace {

const double kNaN = std::nan("");
const double kInfinity = std::numeric_limits<double>::infinity();

FixReading good() {
  FixReading reading{.has_fix = true, .point = {50.0, 9.0, 120.0}, .has_covariance = true};
  reading.covariance_m2 = Eigen::Vector3d{1.0, 2.0, 9.0}.asDiagonal();
  return reading;
}

TEST(FixCheck, takes_a_fix_as_it_is) {
  const auto fix = check_fix(good(), {});
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->covariance_m2, good().covariance_m2);
  EXPECT_FALSE(fix->covariance_was_unknown);
}

TEST(FixCheck, refuses_by_cause) {
  struct Case {
    GeoPoint point;
    Refusal cause;
  };
  for (const Case& c : {Case{{kNaN, 9.0, 1.0}, Refusal::NotFinite}, Case{{50.0, kInfinity, 1.0}, Refusal::NotFinite},
                        Case{{50.0, 9.0, kNaN}, Refusal::NotFinite}, Case{{90.01, 9.0, 1.0}, Refusal::OutOfRange},
                        Case{{-1e300, 9.0, 1.0}, Refusal::OutOfRange}, Case{{0.0, 361.0, 1.0}, Refusal::OutOfRange}}) {
    FixReading reading = good();
    reading.point = c.point;
    const auto fix = check_fix(reading, {});
    ASSERT_FALSE(fix) << explain(c.cause);
    EXPECT_EQ(fix.error(), c.cause);
    EXPECT_STRNE(explain(fix.error()), "");
  }
  FixReading none = good();
  none.has_fix = false;
  none.point.latitude_deg = kNaN;
  EXPECT_EQ(check_fix(none, {}).error(), Refusal::NoFix) << "not a number, because there is none";
}

TEST(FixCheck, needs_no_altitude_on_a_plane) {
  FixReading reading = good();
  reading.point.altitude_m = kNaN;
  reading.covariance_m2(2, 2) = 0.0;
  const auto fix = check_fix(reading, {.ignores_altitude = true});
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->point.altitude_m, 0.0);
  EXPECT_FALSE(fix->covariance_was_unknown);
}

TEST(FixCheck, gives_a_fix_without_a_usable_covariance_the_one_of_the_rules) {
  std::vector<FixReading> readings(5, good());
  readings[0].has_covariance = false;
  readings[1].covariance_m2.setZero();
  readings[2].covariance_m2(0, 1) = kNaN;
  readings[3].covariance_m2(1, 1) = -1.0;
  readings[4].covariance_m2(2, 2) = kInfinity;
  for (const FixReading& reading : readings) {
    const auto fix = check_fix(reading, {.stddev_if_unknown_m = 3.0});
    ASSERT_TRUE(fix);
    EXPECT_TRUE(fix->covariance_was_unknown);
    EXPECT_EQ(fix->covariance_m2.diagonal(), (Eigen::Vector3d{9.0, 9.0, 36.0}));
  }
}

TEST(FixCheck, an_orientation_needs_a_known_heading) {
  std::array<double, 9> covariance{};
  EXPECT_TRUE(check_orientation(Eigen::Quaterniond::Identity(), covariance)) << "unknown, but there is one";
  const auto longer = check_orientation({1.05, 0.0, 0.0, 0.0}, covariance);
  ASSERT_TRUE(longer);
  EXPECT_NEAR(longer->norm(), 1.0, 1e-15);
  EXPECT_EQ(check_orientation({0.0, 0.0, 0.0, 0.0}, covariance).error(), Refusal::NoOrientation);
  EXPECT_EQ(check_orientation({kNaN, 0.0, 0.0, 0.0}, covariance).error(), Refusal::NotFinite);
  covariance[8] = M_PI * M_PI / 3.0;
  EXPECT_EQ(check_orientation(Eigen::Quaterniond::Identity(), covariance).error(), Refusal::UnknownHeading)
      << "what nacelle_imu_filter says without a magnetometer";
  covariance[0] = -1.0;
  EXPECT_EQ(check_orientation(Eigen::Quaterniond::Identity(), covariance).error(), Refusal::NoOrientation) << "REP 145";
}

}  // namespace
}  // namespace nacelle::navsat
