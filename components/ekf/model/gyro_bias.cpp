// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/gyro_bias.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "ekf/model/process_model.hpp"
#include "nacelle/spatial/angles.hpp"

namespace nacelle::ekf {
namespace {

constexpr int kJoint = kStates + 3;
using JointMatrix = Eigen::Matrix<double, kJoint, kJoint>;
// Of as many rows as a reading has; never on the heap.
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kStates, kStates>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, kStates, 3>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kStates, 1>;

bool has_bias(int state, const GyroBiasOptions& options) {
  return state == kVyaw || (!options.yaw_only && (state == kVroll || state == kVpitch));
}

// Replaces a rate w by w + sign * b, in mean and covariance: P by T P T^T with T = 1 but for one entry.
void shear(Belief& belief, GyroBias& bias, int state, double sign) {
  const int axis = state - kVroll;
  belief.mean[state] += sign * bias.mean_rps[axis];
  StateCovariance& P = belief.covariance;
  const double variance = P(state, state) + 2.0 * sign * bias.cross(state, axis) + bias.covariance(axis, axis);
  for (int j = 0; j < kStates; ++j) P(state, j) = P(j, state) = P(state, j) + sign * bias.cross(j, axis);
  P(state, state) = variance;
  bias.cross.row(state) += sign * bias.covariance.row(axis);
}

void shear_rates(Belief& belief, GyroBias& bias, const Reading& reading, double sign, const GyroBiasOptions& options) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(reading.rows); ++k) {
    if (has_bias(reading.index[k], options)) shear(belief, bias, reading.index[k], sign);
  }
}

// P + sign * A B A^T, in place.
void add_square(StateCovariance& P, const GyroBias::Cross& A, const Eigen::Matrix3d& B, double sign) {
  const GyroBias::Cross AB = A * B;
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j <= i; ++j) P(i, j) = P(j, i) = P(i, j) + sign * AB.row(i).dot(A.row(j));
  }
}

// The belief of the 15 states if the bias were known, and in the place of C how they change with the bias, V = C B^-1.
// False, and nothing is changed, if rounding leaves no covariance.
bool separate(Belief& belief, GyroBias& bias) {
  const Eigen::Matrix3d inverse = bias.covariance.inverse();
  const GyroBias::Cross V = bias.cross * inverse;
  StateCovariance known = belief.covariance;
  add_square(known, V, bias.covariance, -1.0);
  if (!is_positive_definite(known)) return false;
  belief.covariance = known;
  bias.cross = V;
  return true;
}

void join(Belief& belief, GyroBias& bias) {
  add_square(belief.covariance, bias.cross, bias.covariance, 1.0);
  bias.cross = (bias.cross * bias.covariance).eval();
}

// R as ekf::fuse() takes it.
Square noise_of(const Reading& reading) {
  Square R(reading.rows, reading.rows);
  for (int k = 0; k < reading.rows; ++k) {
    const double* const row = reading.covariance.data() + std::ptrdiff_t{k} * kStates;
    for (int l = 0; l < reading.rows; ++l) R(k, l) = row[l];
    R(k, k) = std::max(std::abs(R(k, k)), kSmallestVariance);
  }
  return R;
}

// Rounding may cost the joint matrix its definiteness. Each variance is raised by the same share of it.
bool restore_definiteness(StateCovariance& covariance, GyroBias& bias) {
  bool repaired = false;
  for (double share = 1e-16; !is_positive_definite(covariance, bias); share *= 4.0) {
    for (int i = 0; i < kStates; ++i) covariance(i, i) *= 1.0 + share;
    bias.covariance.diagonal() *= 1.0 + share;
    repaired = true;
  }
  return repaired;
}

}  // namespace

GyroBias unknown_bias(const GyroBiasOptions& options) {
  GyroBias bias;
  bias.covariance.diagonal().setConstant(options.stddev_rps * options.stddev_rps);
  return bias;
}

void advance(GyroBias& bias, const StateVector& before, double dt_s, const GyroBiasOptions& options) {
  bias.cross = (jacobian(before, dt_s) * bias.cross).eval();
  const double growth = options.drift_rps_per_sqrt_s * options.drift_rps_per_sqrt_s * dt_s;
  const double most = options.stddev_rps * options.stddev_rps;
  for (int i = 0; i < 3; ++i) {
    if (bias.covariance(i, i) + growth <= most) bias.covariance(i, i) += growth;
  }
}

Result<Fused, UpdateFault> fuse(Belief& belief, GyroBias& bias, const Reading& reading, bool of_gyro,
                                const GyroBiasOptions& options) {
  const int m = reading.rows;
  Belief after = belief;
  GyroBias joint = bias;
  if (!of_gyro && !reading.witness.teaches_bias && separate(after, joint)) {
    auto fused = fuse(after, reading);
    if (!fused) return err(fused.error());
    join(after, joint);
    fused->repaired = restore_definiteness(after.covariance, joint) || fused->repaired;
    belief = after;
    bias = joint;
    return *fused;
  }
  if (of_gyro) shear_rates(after, joint, reading, 1.0, options);

  // What the gain of the bias needs of the prior: S = H P H^T + R and the rows H C; K = P H^T S^-1 of the 15 is fuse()'s own.
  const Square R = noise_of(reading);
  Square S = R;
  Columns HC(m, 3);
  Column innovation(m);
  Eigen::Matrix<double, kStates, Eigen::Dynamic, Eigen::ColMajor, kStates, kStates> PH(kStates, m);
  for (int k = 0; k < m; ++k) {
    const int at = reading.index[static_cast<std::size_t>(k)];
    for (int l = 0; l < m; ++l) S(k, l) += after.covariance(at, reading.index[static_cast<std::size_t>(l)]);
    HC.row(k) = joint.cross.row(at);
    const double gap = reading.value[static_cast<std::size_t>(k)] - after.mean[at];
    innovation[k] = at >= kRoll && at <= kYaw ? spatial::wrap_to_pi(gap) : gap;
    for (int i = 0; i < kStates; ++i) PH(i, k) = after.covariance(i, at);
  }
  auto fused = fuse(after, reading);
  if (!fused) return err(fused.error());
  const Eigen::LLT<Square> factor(S);
  if (factor.info() != Eigen::Success) return err(UpdateFault::SingularInnovation);
  const Columns white = factor.matrixL().solve(HC);  // L^-1 H C
  const Columns X = factor.solve(HC);                // S^-1 H C: the gain of the bias, transposed

  joint.cross.noalias() -= PH * X;
  const Columns measured = R * X;  // (H - H K H) C = R S^-1 H C, in which nothing cancels
  for (int k = 0; k < m; ++k) joint.cross.row(reading.index[static_cast<std::size_t>(k)]) = measured.row(k);
  joint.mean_rps.noalias() += X.transpose() * innovation;
  joint.covariance.noalias() -= white.transpose() * white;
  joint.covariance = (0.5 * (joint.covariance + joint.covariance.transpose())).eval();
  if (of_gyro) shear_rates(after, joint, reading, -1.0, options);
  fused->repaired = restore_definiteness(after.covariance, joint) || fused->repaired;
  belief = after;
  bias = joint;
  return *fused;
}

void take_bias_off(Belief& belief, GyroBias& bias, const Reading& reading, const GyroBiasOptions& options) {
  shear_rates(belief, bias, reading, -1.0, options);
}

bool is_positive_definite(const StateCovariance& covariance, const GyroBias& bias) {
  JointMatrix joint;
  joint.topLeftCorner<kStates, kStates>() = covariance.matrix();
  joint.bottomLeftCorner<3, kStates>() = bias.cross.transpose();
  joint.bottomRightCorner<3, 3>() = bias.covariance;
  // By the lower triangle, scaled to ones on the diagonal: position and bias differ by ten orders of magnitude.
  const Eigen::Matrix<double, kJoint, 1> variances = joint.diagonal();
  if (!(variances.minCoeff() > 0.0)) return false;
  const Eigen::Matrix<double, kJoint, 1> scale = variances.cwiseSqrt().cwiseInverse();
  return Eigen::LLT<JointMatrix>(scale.asDiagonal() * joint * scale.asDiagonal()).info() == Eigen::Success;
}

}  // namespace nacelle::ekf
