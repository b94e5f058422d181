// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace nacelle::imu_filter {

/// The directions that a world frame gives names to, as unit vectors of that frame.
struct WorldFrame {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d north = Eigen::Vector3d::UnitY();  ///< Horizontal; magnetic.

  /// x east, y north, z up (REP 103, REP 145).
  [[nodiscard]] static WorldFrame enu() { return {}; }
  /// x north, y west, z up.
  [[nodiscard]] static WorldFrame nwu() { return {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()}; }
  /// x north, y east, z down.
  [[nodiscard]] static WorldFrame ned() { return {-Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()}; }
};

/// One reading of an IMU, in the sensor's axes.
struct Measurement {
  Eigen::Vector3d angular_velocity_rps{Eigen::Vector3d::Zero()};
  /// Gravity included: points up at rest (REP 145). Zero: nothing known, the gyro alone counts.
  Eigen::Vector3d acceleration_mps2{Eigen::Vector3d::Zero()};
  std::optional<Eigen::Vector3d> magnetic_field{};  ///< In any unit: its direction counts.
  double dt_s = 0.0;                                ///< Since the measurement before.
};

/// Estimates how a sensor is turned in the world from gyro, accelerometer and, if there is one, magnetometer.
///
/// Frame: orientation() is R_WS, sensor to world. Threads: one. Allocates: nothing.
class OrientationFilter {
 public:
  explicit OrientationFilter(const WorldFrame& world) : world_(world) {}
  OrientationFilter(const OrientationFilter&) = delete;
  OrientationFilter& operator=(const OrientationFilter&) = delete;
  virtual ~OrientationFilter() = default;

  /// Takes the orientation that one reading at rest shows. Without a usable field the sensor's x axis points along
  /// the world's. Returns false, and changes nothing, if there is no acceleration.
  bool start(const Measurement& at_rest);
  /// Starts from a known orientation, with the gyro's bias as it is.
  void start_at(const Eigen::Quaterniond& R_WS);
  /// Mends the tilt from one acceleration and keeps the heading: after a gap in which turns were not seen.
  void level(const Eigen::Vector3d& acceleration_mps2);
  /// Goes one measurement on. Precondition: all values are finite and dt_s is positive.
  void update(const Measurement& measurement);

  [[nodiscard]] const Eigen::Quaterniond& orientation() const { return R_WS_; }
  /// The gyro's bias as the filter has estimated it; zero if it estimates none.
  [[nodiscard]] const Eigen::Vector3d& bias_rps() const { return bias_rps_; }

 protected:
  /// Turns the orientation by what the gyro saw (its mean of this and the last reading, the exact exponential).
  void turn(const Eigen::Vector3d& angular_velocity_rps, double dt_s);
  virtual void correct(const Measurement& measurement) = 0;

  const WorldFrame world_;
  Eigen::Quaterniond R_WS_{Eigen::Quaterniond::Identity()};
  Eigen::Vector3d bias_rps_{Eigen::Vector3d::Zero()};
  std::optional<Eigen::Vector3d> last_rps_{};  ///< As measured.
};

}  // namespace nacelle::imu_filter
