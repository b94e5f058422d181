// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "ekf/model/update.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::ekf {

struct GyroBiasOptions {
  bool on = false;
  bool yaw_only = false;  ///< With two_d_mode: the rates of roll and pitch are held at 0, so their bias is not needed.
  double stddev_rps = 0.02;            ///< Of the bias of each axis before anything is known, rad/s.
  double drift_rps_per_sqrt_s = 1e-4;  ///< Random walk. The variance never grows beyond that of the start.
};

/// Three states beside the 15: the bias b of one gyro, along the axes of B. The gyro measures w + b.
///
/// The belief of the filter stays the marginal one of its 15 states; here are the rest of the mean and of the 18x18 covariance
/// [P C; C^T B]. A filter without the switch does not touch any of it.
/// Threads: a value. Allocates: nothing.
struct GyroBias {
  using Cross = Eigen::Matrix<double, kStates, 3>;
  Eigen::Vector3d mean_rps = Eigen::Vector3d::Zero();
  Cross cross = Cross::Zero();                           ///< C: of the 15 states and the bias.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< B, (rad/s)^2.
};

/// The bias before the first measurement.
[[nodiscard]] GyroBias unknown_bias(const GyroBiasOptions& options);

/// Moves cross terms and variance on, beside ekf::advance() of the belief; `before` is the mean that is moved on.
/// C = J C; B grows by the drift.
void advance(GyroBias& bias, const StateVector& before, double dt_s, const GyroBiasOptions& options);

/// Fuses a reading into belief and bias at once. With `of_gyro` its rates are w + b, else they are w.
/// A reading whose witness does not teach the bias is weighed as if the bias were known, and leaves V = C B^-1 as it is: the
/// means are those of a filter without the bias, and the covariance P = P_known + V B V^T stays honest about it.
/// On a fault both stand as they were.
///
/// Source:    Kalman update of the joint state. With u = w + b in the place of w a gyro measures states alone, so that
///            ekf::fuse() serves: the joint covariance is sheared, updated and sheared back.
/// Cost:      about 4 times that of ekf::fuse().
/// Threads:   pure. Allocates: nothing.
[[nodiscard]] Result<Fused, UpdateFault> fuse(Belief& belief, GyroBias& bias, const Reading& reading, bool of_gyro,
                                              const GyroBiasOptions& options);

/// Makes w of a belief that was initialised by the gyro: what it believes is w + b.
void take_bias_off(Belief& belief, GyroBias& bias, const Reading& reading, const GyroBiasOptions& options);

/// Whether the joint covariance of the 18 states has a Cholesky factor.
[[nodiscard]] bool is_positive_definite(const StateCovariance& covariance, const GyroBias& bias);

}  // namespace nacelle::ekf
