// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "drives.hpp"
#include "ekf/model/wheeled_noise.hpp"

namespace nacelle::ekf::honesty {

/// How the filter is set up.
struct Setup {
  bool wheeled = true;  ///< Else robot_localization's process noise.
  VehicleLimits limits;
  odometry::SlipModel slip;
  double frequency_hz = 50.0;
  double gyro_stddev_rps = 0.002;  ///< The IMU component's default.
  bool adaptive = false;           ///< Of every input.
};
/// The default robot's: launch/config/robot.yaml.
[[nodiscard]] Setup default_robot();
/// A vehicle like that of the recorded drives: 2 m/s, 1 m/s^2, 1 rad/s, odometry of 5 Hz on rough ground.
[[nodiscard]] Setup outdoor_vehicle();

/// The planar estimate beside the truth.
struct Estimate {
  TruePose truth;
  double x_m{}, y_m{}, yaw_rad{};
  double covariance[3][3]{};  ///< x, y, yaw.
};
/// Runs the filter over a drive, from the true pose at `from_s` to `to_s`, and returns what it publishes, at its rate.
[[nodiscard]] std::vector<Estimate> run(const Drive& drive, const Setup& setup, double from_s, double to_s);
[[nodiscard]] std::vector<Estimate> run(const Drive& drive, const Setup& setup);

/// Normalised errors of the motion from the beginning to the end of windows that follow each other.
///
/// The filter of each window starts a second earlier at the true pose, so that its velocity has settled, and the pose at the
/// beginning is nearly certain: the difference of covariances of hundreds of metres would be rounding.
struct WindowErrors {
  std::vector<double> position;      ///< e^T C^-1 e of (x, y): 2 degrees of freedom.
  std::vector<double> yaw;           ///< e^2 / C: 1 degree of freedom.
  double position_m2{}, yaw_rad2{};  ///< Sums of the squared errors themselves.
};
/// The motion is what is seen from the pose at the beginning. Its covariance is what the filter's own grew by: with F the slope of the
/// pose at the end by that at the beginning, C = G^-1 (P_end - F P_begin F^T) G^-T, G turning the axes to those of the beginning.
[[nodiscard]] WindowErrors relative_errors(const Drive& drive, const Setup& setup, double window_s);
/// The motion from one estimate to a later one of the same run.
struct Motion {
  double error[3]{};          ///< Truth minus estimate: along, across, yaw.
  double covariance[3][3]{};  ///< The filter's.
};
[[nodiscard]] Motion motion_between(const Estimate& begin, const Estimate& end);

/// What windows say together.
struct Honesty {
  double mean{};      ///< Per degree of freedom; 1 is right.
  double coverage{};  ///< The share of the windows within the 95 % region.
};
/// `freedom`: 1 or 2.
[[nodiscard]] Honesty honesty_of(const std::vector<double>& nees, int freedom);

/// The 95 % band of the mean of `runs` independent normalised errors, per degree of freedom: chi-squared with runs x freedom degrees.
/// Source: Wilson and Hilferty's approximation of its quantiles, within 0.01 from 10 degrees on.
struct Band {
  double low{}, high{};
};
[[nodiscard]] Band band_of_mean(int runs, int freedom);

}  // namespace nacelle::ekf::honesty
