// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/drive_model.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

namespace nacelle::simulation {
namespace {

constexpr double kPi = std::numbers::pi;

WorldSettings perfect() {
  WorldSettings settings;
  settings.errors = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  return settings;
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(WorldDefaults, are_the_ones_the_drive_is_accepted_in) {
  const WorldSettings settings;
  EXPECT_EQ(settings.errors.wheel_radius, 0.003);
  EXPECT_EQ(settings.errors.track, 0.01);
  EXPECT_EQ(settings.errors.slip, 0.005);
  EXPECT_EQ(settings.errors.gyro_bias_dps, 0.1);
  EXPECT_EQ(settings.errors.gyro_noise_dps, 0.1);
  EXPECT_EQ(settings.errors.range_noise_m, 0.010);
  EXPECT_EQ(settings.robot.wheel_radius_m, 0.033);
  EXPECT_EQ(settings.robot.track_m, 0.30);
  EXPECT_EQ(settings.robot.counts_per_turn, 1440);
}

TEST(WorldDefaults, are_really_drawn_with_those_deviations) {
  const Room room = Room::with_two_boxes();
  std::vector<double> radii, tracks, slips;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    const DriveModel drive{{.seed = seed}, room};
    radii.push_back(drive.geometry().left_radius_m / 0.033 - 1.0);
    radii.push_back(drive.geometry().right_radius_m / 0.033 - 1.0);
    tracks.push_back(drive.geometry().track_m / 0.30 - 1.0);
    slips.push_back(drive.left_slip());
    slips.push_back(drive.right_slip());
  }
  // The deviation of 2000 draws is known to 1.6 %; the bound is six times that.
  EXPECT_NEAR(rms(radii), 0.003, 0.0003);
  EXPECT_NEAR(rms(tracks), 0.01, 0.001);
  EXPECT_NEAR(rms(slips), 0.005, 0.0005);
}

TEST(Random, gives_the_same_numbers_everywhere) {
  // Golden: std::mt19937_64 is fixed by the standard; a change here changes every world.
  Random random{1, 1};
  EXPECT_DOUBLE_EQ(random.uniform(), Random(1, 1).uniform());
  EXPECT_NE(Random(1, 1).uniform(), Random(1, 2).uniform());
  EXPECT_NE(Random(1, 1).uniform(), Random(2, 1).uniform());
  std::mt19937_64 reference;
  reference.discard(9999);
  EXPECT_EQ(reference(), 9981545732273789042ULL);
}

TEST(DriveModel, slip_changes_once_a_second) {
  const Room room = Room::with_two_boxes();
  DriveModel drive{{.seed = 4}, room};
  int changes = 0;
  double before = drive.left_slip();
  for (int step = 0; step < 5000; ++step) {
    drive.step(0.001, 0.0, 0.0);
    if (drive.left_slip() != before) ++changes;
    before = drive.left_slip();
  }
  EXPECT_EQ(changes, 5);
}

TEST(DriveModel, a_perfect_robot_goes_straight_as_far_as_its_wheels_roll) {
  const Room room = Room::with_two_boxes();
  DriveModel drive{perfect(), room};
  const double rate_rps = 0.2 / 0.033;
  for (int step = 0; step < 4000; ++step) drive.step(0.001, rate_rps, rate_rps);
  EXPECT_NEAR(drive.pose().x_m, drive.left_angle_rad() * 0.033, 1e-9);
  EXPECT_NEAR(drive.pose().x_m, 0.2 * (4.0 - 0.05), 1e-3) << "the lag costs one time constant";
  EXPECT_NEAR(drive.pose().y_m, 0.0, 1e-12);
}

TEST(DriveModel, the_motors_reach_63_percent_in_one_time_constant) {
  const Room room = Room::with_two_boxes();
  DriveModel drive{perfect(), room};
  for (int step = 0; step < 50; ++step) drive.step(0.001, 1.0 / 0.033, 1.0 / 0.033);
  EXPECT_NEAR(drive.speed_mps(), 1.0 - std::exp(-1.0), 1e-9);
}

TEST(DriveModel, a_robot_that_turns_on_the_spot_stays_there) {
  const Room room = Room::with_two_boxes();
  DriveModel drive{perfect(), room};
  for (int step = 0; step < 3000; ++step) drive.step(0.001, -5.0, 5.0);
  EXPECT_NEAR(drive.pose().x_m, 0.0, 1e-9);
  EXPECT_NEAR(drive.pose().y_m, 0.0, 1e-9);
  EXPECT_NEAR(drive.pose().yaw_rad, (drive.right_angle_rad() - drive.left_angle_rad()) * 0.033 / 0.30, 1e-9);
}

TEST(DriveModel, a_wall_stops_the_robot_but_not_its_wheels) {
  const Room room = Room::with_two_boxes();
  DriveModel drive{perfect(), room};
  for (int step = 0; step < 20000; ++step) drive.step(0.001, 10.0, 10.0);
  EXPECT_GT(drive.contacts(), 0U);
  EXPECT_NEAR(drive.pose().x_m, 2.0 - 0.16, 0.002);
  EXPECT_EQ(drive.speed_mps(), 0.0);
  for (int step = 0; step < 2000; ++step) drive.step(0.001, -10.0, -10.0);
  EXPECT_LT(drive.pose().x_m, 1.5) << "it can leave again";
}

TEST(Room, the_square_of_the_drive_is_free) {
  const Room room = Room::with_two_boxes();
  for (double side = 0.0; side <= 1.0; side += 0.05) {
    EXPECT_GT(room.clearance_m(side, 0.0), 0.8) << side;
    EXPECT_GT(room.clearance_m(1.0, side), 0.8) << side;
    EXPECT_GT(room.clearance_m(side, 1.0), 0.8) << side;
    EXPECT_GT(room.clearance_m(0.0, side), 0.8) << side;
  }
}

TEST(Room, a_ray_ends_at_the_nearest_wall) {
  const Room room = Room::with_two_boxes();
  EXPECT_NEAR(room.range_m(0.0, 0.0, 0.0), 2.0, 1e-12);
  EXPECT_NEAR(room.range_m(0.0, 0.0, kPi / 2), 2.0, 1e-12);
  EXPECT_NEAR(room.range_m(0.0, 0.0, kPi / 4), 2.0 * std::numbers::sqrt2, 1e-12);
  EXPECT_NEAR(room.range_m(0.0, 1.1, kPi), 1.1, 1e-12) << "the box";
  EXPECT_NEAR(room.clearance_m(0.0, 1.1), 0.9, 1e-12) << "the wall behind";
}

TEST(KnownErrors, stand_in_for_the_draws_and_leave_the_others_as_they_were) {
  const Room room = Room::with_two_boxes();
  const DriveModel drawn{{.seed = 4}, room};
  WorldSettings settings{.seed = 4};
  settings.known.left_radius = 0.02;
  settings.known.track = -0.03;
  const DriveModel chosen{settings, room};
  EXPECT_DOUBLE_EQ(chosen.geometry().left_radius_m, 0.033 * 1.02);
  EXPECT_DOUBLE_EQ(chosen.geometry().track_m, 0.30 * 0.97);
  EXPECT_EQ(chosen.geometry().right_radius_m, drawn.geometry().right_radius_m);
  EXPECT_EQ(chosen.left_slip(), drawn.left_slip());
}

TEST(DriveModel, accelerates_its_turn_as_the_yaw_rate_grows) {
  const Room room = Room::with_two_boxes();
  DriveModel drive{perfect(), room};
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) {
    drive.step(0.001, -2.0, 2.0);
    sum += drive.yaw_acceleration_rps2() * 0.001;
  }
  EXPECT_NEAR(sum, drive.yaw_rate_rps(), 1e-9);
}

}  // namespace
}  // namespace nacelle::simulation
