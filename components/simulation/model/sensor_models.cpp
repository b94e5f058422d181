// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/sensor_models.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::simulation {
namespace {

constexpr std::uint64_t kRangeStream = 3, kImuConstantStream = 4, kImuNoiseStream = 5;
constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kGravityMps2 = 9.80665;
// Central Europe: 20 uT to the north, 43 uT into the ground; 0.15 uT per count is the AK8963's unit.
constexpr double kNorthCounts = 20.0 / 0.15, kDownCounts = 43.0 / 0.15;
constexpr double kFarthestM = 12.0;

}  // namespace

LidarModel::LidarModel(const WorldSettings& settings, const Room& room)
    : noise_m_(settings.errors.range_noise_m), room_(room), draws_(settings.seed, kRangeStream) {
  packet_.speed_dps = 360 * kTurnsPerSecond;
}

Duration LidarModel::next_point() const {
  return Duration{static_cast<std::int64_t>(count_ * 1'000'000'000ULL / kPointsPerSecond)};
}

std::optional<Ld06Packet> LidarModel::measure(const Pose& pose) {
  constexpr std::uint64_t kPointsPerTurn = kPointsPerSecond / kTurnsPerSecond;
  const auto angle_cdeg = static_cast<std::uint16_t>(count_ % kPointsPerTurn * 36000 / kPointsPerTurn);
  const std::size_t slot = count_ % packet_.points.size();
  const auto time_ms = static_cast<std::uint16_t>(next_point().count() / 1'000'000 % 30000);
  ++count_;

  // The device turns clockwise, the world counts counter-clockwise.
  const double range_m = room_.range_m(pose.x_m, pose.y_m, pose.yaw_rad - angle_cdeg / 100.0 / kDegPerRad);
  const double noise_m = draws_.normal(noise_m_);  // drawn for a point without return as well: one point, one draw
  auto& point = packet_.points[slot];
  point = {};
  if (range_m <= kFarthestM) {
    point.range_mm = static_cast<std::uint16_t>(std::clamp(std::lround((range_m + noise_m) * 1000.0), 1L, 65535L));
    point.intensity = static_cast<std::uint8_t>(std::clamp(230.0 - 12.0 * range_m, 20.0, 230.0));
  }
  if (slot == 0) packet_.start_cdeg = angle_cdeg;
  if (slot + 1 < packet_.points.size()) return std::nullopt;
  packet_.end_cdeg = angle_cdeg;
  packet_.time_ms = time_ms;
  return packet_;
}

ImuModel::ImuModel(const WorldSettings& settings)
    : errors_(settings.errors),
      known_(settings.known),
      constants_(settings.seed, kImuConstantStream),
      draws_(settings.seed, kImuNoiseStream) {
  for (double& bias : gyro_bias_dps_) bias = constants_.normal(errors_.gyro_bias_dps);
  for (double& bias : accelerometer_bias_g_) bias = constants_.normal(errors_.accelerometer_bias_g);
  heading_amplitude_rad_ = constants_.normal(errors_.heading_error_deg) / kDegPerRad;
  heading_phase_rad_ = 2.0 * std::numbers::pi * constants_.uniform();
}

Wt901Reading ImuModel::measure(const DriveModel& drive) {
  Wt901Reading reading;
  // Its axes' yaw; a vector of the base is turned back by known_.imu_yaw_rad into them.
  const double yaw_rad = drive.pose().yaw_rad + known_.imu_yaw_rad;
  const double c = std::cos(known_.imu_yaw_rad), s = std::sin(known_.imu_yaw_rad);
  // Of a point of a rigid body: a + alpha x r + w x (w x r).
  const double w = drive.yaw_rate_rps(), alpha = drive.yaw_acceleration_rps2();
  const double ahead_mps2 = drive.acceleration_mps2() - alpha * known_.imu_y_m - w * w * known_.imu_x_m;
  const double left_mps2 = drive.speed_mps() * w + alpha * known_.imu_x_m - w * w * known_.imu_y_m;
  const std::array<double, 3> acceleration_mps2{c * ahead_mps2 + s * left_mps2, c * left_mps2 - s * ahead_mps2,
                                                kGravityMps2};
  const std::array<double, 3> rate_dps{0.0, 0.0, drive.yaw_rate_rps() * kDegPerRad};
  // Earth's field seen from the sensor: north is the world's y axis.
  const std::array<double, 3> field{kNorthCounts * std::sin(yaw_rad), kNorthCounts * std::cos(yaw_rad), -kDownCounts};
  for (std::size_t i = 0; i < 3; ++i) {
    reading.acceleration_g[i] =
        acceleration_mps2[i] / kGravityMps2 + accelerometer_bias_g_[i] + draws_.normal(errors_.accelerometer_noise_g);
    reading.angular_velocity_dps[i] = rate_dps[i] + gyro_bias_dps_[i] + draws_.normal(errors_.gyro_noise_dps);
    reading.magnetic_field_counts[i] = field[i] + draws_.normal(errors_.magnetometer_noise_counts);
  }
  // The device's own filter follows the turn and leans on the magnetic heading, which the robot's iron bends.
  const double heading_rad =
      yaw_rad + heading_amplitude_rad_ * (std::sin(yaw_rad + heading_phase_rad_) - std::sin(heading_phase_rad_)) +
      draws_.normal(0.05) / kDegPerRad;
  const double roll_rad = draws_.normal(0.02) / kDegPerRad;
  const double pitch_rad = draws_.normal(0.02) / kDegPerRad;
  reading.angles_deg = {roll_rad * kDegPerRad, pitch_rad * kDegPerRad,
                        std::remainder(heading_rad, 2.0 * std::numbers::pi) * kDegPerRad};
  // Small roll and pitch: their half angles, turned by the yaw.
  const double ch = std::cos(heading_rad / 2.0), sh = std::sin(heading_rad / 2.0);
  reading.quaternion = {ch, ch * roll_rad / 2.0 - sh * pitch_rad / 2.0, ch * pitch_rad / 2.0 + sh * roll_rad / 2.0, sh};
  return reading;
}

}  // namespace nacelle::simulation
