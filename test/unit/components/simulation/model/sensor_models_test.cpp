// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/sensor_models.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace nacelle::simulation {
namespace {

double stddev(const std::vector<double>& values, double mean) {
  double sum = 0;
  for (const double v : values) sum += (v - mean) * (v - mean);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(LidarModel, measures_with_ten_millimetres_of_noise) {
  const Room room = Room::with_two_boxes();
  LidarModel lidar{{.seed = 3}, room};
  std::vector<double> errors;
  for (int i = 0; i < 9000; ++i) {
    const auto packet = lidar.measure({});
    if (!packet) continue;
    for (std::size_t p = 0; p < 12; ++p) {
      const double angle_rad = (packet->start_cdeg / 100.0 + 0.8 * static_cast<double>(p)) * M_PI / 180.0;
      errors.push_back(packet->points[p].range_mm / 1000.0 - room.range_m(0.0, 0.0, -angle_rad));
    }
  }
  ASSERT_GT(errors.size(), 8000U);
  EXPECT_NEAR(stddev(errors, 0.0), 0.010, 0.001);
}

TEST(LidarModel, gives_375_packets_a_second_of_ten_turns) {
  const Room room = Room::with_two_boxes();
  LidarModel lidar{{}, room};
  int packets = 0, turns = 0;
  unsigned last_start = 0;
  while (lidar.next_point() < 1s) {
    const auto packet = lidar.measure({});
    if (!packet) continue;
    ++packets;
    if (packet->start_cdeg < last_start) ++turns;
    last_start = packet->start_cdeg;
    EXPECT_EQ(packet->speed_dps, 3600);
    EXPECT_EQ((packet->end_cdeg + 36000U - packet->start_cdeg) % 36000U, 880U);
  }
  EXPECT_EQ(packets, 375);
  EXPECT_EQ(turns, 9) << "the tenth begins with the next second";
}

TEST(LidarModel, sees_nothing_beyond_twelve_metres) {
  const Room far{{{13.0, -50.0, 13.0, 50.0}}};
  LidarModel lidar{{}, far};
  for (int i = 0; i < 450; ++i) {
    const auto packet = lidar.measure({});
    if (!packet) continue;
    for (const auto& point : packet->points) EXPECT_EQ(point.range_mm, 0);
  }
}

TEST(ImuModel, has_the_bias_and_noise_of_the_defaults) {
  const Room room = Room::with_two_boxes();
  std::vector<double> biases, noise;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    const WorldSettings settings{.seed = seed};
    ImuModel imu{settings};
    const DriveModel at_rest{settings, room};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      biases.push_back(imu.gyro_bias_dps()[axis]);
      noise.push_back(imu.measure(at_rest).angular_velocity_dps[axis] - imu.gyro_bias_dps()[axis]);
    }
  }
  EXPECT_NEAR(stddev(biases, 0.0), 0.1, 0.01);
  EXPECT_NEAR(stddev(noise, 0.0), 0.1, 0.01);
}

TEST(ImuModel, feels_gravity_upwards_and_turns_to_the_left_as_positive) {
  WorldSettings settings;
  settings.errors = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const Room room = Room::with_two_boxes();
  DriveModel drive{settings, room};
  ImuModel imu{settings};
  for (int i = 0; i < 1000; ++i) drive.step(0.001, -2.0, 2.0);
  const Wt901Reading reading = imu.measure(drive);
  EXPECT_NEAR(reading.acceleration_g[2], 1.0, 1e-9);
  EXPECT_NEAR(reading.angular_velocity_dps[2], 2.0 * 2.0 * 0.033 / 0.30 * 180.0 / M_PI, 1e-6);
  EXPECT_NEAR(reading.angles_deg[2], drive.pose().yaw_rad * 180.0 / M_PI, 0.5);
  EXPECT_NEAR(2.0 * std::atan2(reading.quaternion[3], reading.quaternion[0]), drive.pose().yaw_rad, 0.01);
  // Having turned to the left of east, the base sees north less far on its left.
  EXPECT_GT(reading.magnetic_field_counts[0], 0.0);
  EXPECT_LT(reading.magnetic_field_counts[2], 0.0);
}

TEST(ImuModel, beside_the_axle_feels_the_turn_pull_and_push) {
  WorldSettings settings;
  settings.errors = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  settings.known.imu_x_m = 0.2;
  settings.known.imu_y_m = -0.1;
  const Room room = Room::with_two_boxes();
  DriveModel drive{settings, room};
  ImuModel imu{settings};
  drive.step(0.001, -10.0, 10.0);
  const double alpha = drive.yaw_acceleration_rps2(), early = drive.yaw_rate_rps();
  Wt901Reading reading = imu.measure(drive);
  EXPECT_GT(alpha, 1.0);
  EXPECT_NEAR(reading.acceleration_g[0] * 9.80665, alpha * 0.1 - early * early * 0.2, 1e-9);
  EXPECT_NEAR(reading.acceleration_g[1] * 9.80665, alpha * 0.2 + early * early * 0.1, 1e-9);
  for (int i = 0; i < 2000; ++i) drive.step(0.001, -10.0, 10.0);
  const double w = drive.yaw_rate_rps();
  reading = imu.measure(drive);
  EXPECT_NEAR(reading.acceleration_g[0] * 9.80665, -w * w * 0.2, 1e-6) << "towards the axle's middle, which is behind";
  EXPECT_NEAR(reading.acceleration_g[1] * 9.80665, w * w * 0.1, 1e-6);
}

TEST(ImuModel, that_is_turned_measures_along_its_own_axes) {
  WorldSettings settings;
  settings.errors = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const Room room = Room::with_two_boxes();
  DriveModel drive{settings, room};
  ImuModel along{settings};
  settings.known.imu_yaw_rad = M_PI / 2.0;
  ImuModel turned{settings};
  for (int i = 0; i < 30; ++i) drive.step(0.001, 5.0, 9.0);
  const Wt901Reading a = along.measure(drive), t = turned.measure(drive);
  EXPECT_GT(a.acceleration_g[0], 0.01);
  EXPECT_NEAR(t.acceleration_g[0], a.acceleration_g[1], 1e-9) << "its x axis looks to the left";
  EXPECT_NEAR(t.acceleration_g[1], -a.acceleration_g[0], 1e-9);
  EXPECT_NEAR(t.angular_velocity_dps[2], a.angular_velocity_dps[2], 1e-9);
  EXPECT_NEAR(t.magnetic_field_counts[0], a.magnetic_field_counts[1], 1e-9);
  EXPECT_NEAR(std::remainder(t.angles_deg[2] - a.angles_deg[2], 360.0), 90.0, 0.5);
}

}  // namespace
}  // namespace nacelle::simulation
