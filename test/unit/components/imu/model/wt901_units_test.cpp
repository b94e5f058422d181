// SPDX-License-Identifier: Apache-2.0
#include "imu/model/wt901_units.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nacelle::imu {
namespace {

constexpr double kPi = std::numbers::pi;

Wt901Frame frame(std::int16_t a, std::int16_t b, std::int16_t c, std::int16_t d = 0) { return {0x51, {a, b, c, d}}; }

TEST(Wt901Units, full_scale_is_sixteen_g_and_two_thousand_degrees_a_second) {
  EXPECT_NEAR(acceleration_mps2(frame(0, 0, 2048))[2], 9.80665, 1e-12);
  EXPECT_NEAR(acceleration_mps2(frame(-32768, 0, 0))[0], -16 * 9.80665, 1e-9);
  EXPECT_NEAR(angular_velocity_rps(frame(0, -32768, 0))[1], -2000 * kPi / 180, 1e-9);
  EXPECT_NEAR(magnetic_field_t(frame(0, 0, 100), 0.15e-6)[2], 15e-6, 1e-18);
}

TEST(Wt901Units, yaw_counts_counter_clockwise_about_z) {
  const Orientation quarter = orientation_from_angles(frame(0, 0, 16384));  // 90 deg
  EXPECT_NEAR(quarter.w, std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(quarter.z, std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(quarter.x, 0.0, 1e-12);
}

TEST(Wt901Units, angles_and_quaternions_of_the_same_attitude_agree) {
  for (const auto& [roll, pitch, yaw] :
       {std::tuple{0.1, 0.2, 0.3}, {-1.0, 0.5, 3.0}, {3.0, -1.5, -3.0}, {0.0, 0.0, kPi}}) {
    const auto count = [](double rad) {
      return static_cast<std::int16_t>(std::clamp(std::lround(rad / kPi * 32768), -32768L, 32767L));
    };
    const Orientation q = orientation_from_angles(frame(count(roll), count(pitch), count(yaw)));
    EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1.0, 1e-12);
    // The rotation matrix's first column is the body's x axis in the world.
    EXPECT_NEAR(1 - 2 * (q.y * q.y + q.z * q.z), std::cos(yaw) * std::cos(pitch), 2e-4);
    EXPECT_NEAR(2 * (q.x * q.y + q.w * q.z), std::sin(yaw) * std::cos(pitch), 2e-4);
    EXPECT_NEAR(2 * (q.x * q.z - q.w * q.y), -std::sin(pitch), 2e-4);
    EXPECT_NEAR(2 * (q.y * q.z + q.w * q.x), std::cos(pitch) * std::sin(roll), 2e-4);
  }
}

TEST(Wt901Units, a_quaternion_is_made_one_long_or_refused) {
  const auto q = orientation_from_quaternion(frame(23170, 0, 0, 23170));
  ASSERT_TRUE(q);
  EXPECT_NEAR(q->w * q->w + q->z * q->z, 1.0, 1e-12);
  EXPECT_FALSE(orientation_from_quaternion(frame(0, 0, 0, 0)));
  EXPECT_FALSE(orientation_from_quaternion(frame(32767, 32767, 32767, 32767)));
}

}  // namespace
}  // namespace nacelle::imu
