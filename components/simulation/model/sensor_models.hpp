// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nacelle/base/time.hpp"
#include "simulation/model/drive_model.hpp"
#include "simulation/protocol/ld06_encoder.hpp"
#include "simulation/protocol/wt901_device.hpp"

namespace nacelle::simulation {

/// An LD06 on the middle of the base: 4500 points/s, 10 turns/s, clockwise.
class LidarModel {
 public:
  LidarModel(const WorldSettings& settings, const Room& room);

  /// When the next point is measured.
  [[nodiscard]] Duration next_point() const;
  /// Measures it from this pose; a packet is full with every twelfth.
  [[nodiscard]] std::optional<Ld06Packet> measure(const Pose& pose);

  static constexpr std::uint64_t kPointsPerSecond = 4500, kTurnsPerSecond = 10;

 private:
  const double noise_m_;
  const Room& room_;
  Random draws_;
  std::uint64_t count_ = 0;
  Ld06Packet packet_;
};

/// A WT901 on the base: accelerometer, gyro, magnetometer, and the attitude it computes from them. It sits level in the middle of the
/// axle with axes along the base's, unless the world's known errors say otherwise.
class ImuModel {
 public:
  explicit ImuModel(const WorldSettings& settings);

  /// A reading of the moving base, with bias and noise.
  [[nodiscard]] Wt901Reading measure(const DriveModel& drive);
  /// What the gyro reads at rest, on average. Units: deg/s.
  [[nodiscard]] const std::array<double, 3>& gyro_bias_dps() const { return gyro_bias_dps_; }

 private:
  const WorldErrors errors_;
  const KnownErrors known_;
  Random constants_, draws_;
  std::array<double, 3> gyro_bias_dps_{}, accelerometer_bias_g_{};
  double heading_amplitude_rad_ = 0.0, heading_phase_rad_ = 0.0;
};

}  // namespace nacelle::simulation
