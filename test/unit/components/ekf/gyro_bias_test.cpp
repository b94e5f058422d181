// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/gyro_bias.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "ekf/model/process_model.hpp"
#include "ekf_cases.hpp"

namespace nacelle::ekf {
namespace {

using JointMatrix = Eigen::Matrix<double, 18, 18>;
using JointVector = Eigen::Matrix<double, 18, 1>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 18>;

struct Joint {
  Belief belief;
  GyroBias bias;

  [[nodiscard]] JointVector mean() const {
    JointVector x;
    x << belief.mean, bias.mean_rps;
    return x;
  }
  [[nodiscard]] JointMatrix covariance() const {
    JointMatrix P;
    P << belief.covariance.matrix(), bias.cross, bias.cross.transpose(), bias.covariance;
    return P;
  }
};

Joint random_joint(std::mt19937& random) {
  std::normal_distribution<double> normal;
  JointMatrix half;
  for (double& value : half.reshaped()) value = normal(random);
  const JointMatrix P = half * half.transpose() * 0.3 + JointMatrix::Identity() * 0.01;
  Joint joint;
  joint.belief.mean = random_state(random);
  joint.belief.covariance = StateMatrix{P.topLeftCorner<15, 15>()};
  joint.bias.cross = P.topRightCorner<15, 3>();
  joint.bias.covariance = P.bottomRightCorner<3, 3>();
  for (double& value : joint.bias.mean_rps) value = 0.1 * normal(random);
  return joint;
}

Reading reading_of(std::initializer_list<StateIndex> states, std::mt19937& random) {
  std::uniform_real_distribution<double> any{-0.5, 0.5};
  Reading reading;
  for (const StateIndex i : states) reading.add(i, any(random), 0.1 + 0.1 * (any(random) + 0.5));
  return reading;
}

Rows matrix_of(const Reading& reading, bool of_gyro, bool yaw_only) {
  Rows H = Rows::Zero(reading.rows, 18);
  for (int k = 0; k < reading.rows; ++k) {
    const int at = reading.index[static_cast<std::size_t>(k)];
    H(k, at) = 1.0;
    if (of_gyro && at >= kVroll && at <= kVyaw && (!yaw_only || at == kVyaw)) H(k, kStates + at - kVroll) = 1.0;
  }
  return H;
}

Eigen::MatrixXd noise_of(const Reading& reading) {
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(reading.rows, reading.rows);
  for (int k = 0; k < reading.rows; ++k) R(k, k) = reading.covariance[static_cast<std::size_t>(k) * (kStates + 1)];
  return R;
}

Eigen::VectorXd innovation_of(const Reading& reading, const Rows& H, const JointVector& mean) {
  Eigen::VectorXd z(reading.rows);
  for (int k = 0; k < reading.rows; ++k) z[k] = reading.value[static_cast<std::size_t>(k)];
  return z - H * mean;
}

constexpr unsigned kSeed = 19;

class JointUpdate : public ::testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(JointUpdate, is_that_of_the_dense_filter_of_18_states) {
  const auto [of_gyro, yaw_only] = GetParam();
  std::mt19937 random{kSeed};
  for (int n = 0; n < 50; ++n) {
    Joint joint = random_joint(random);
    const Joint prior = joint;
    const Reading reading =
        n % 2 == 0 ? reading_of({kVroll, kVpitch, kVyaw}, random) : reading_of({kVx, kYaw, kVyaw, kAx, kZ}, random);
    const Rows H = matrix_of(reading, of_gyro, yaw_only);
    const Eigen::MatrixXd S = H * prior.covariance() * H.transpose() + noise_of(reading);
    const Eigen::MatrixXd K = prior.covariance() * H.transpose() * S.inverse();
    const JointVector mean = prior.mean() + K * innovation_of(reading, H, prior.mean());
    const JointMatrix covariance = prior.covariance() - K * S * K.transpose();

    ASSERT_TRUE(fuse(joint.belief, joint.bias, reading, of_gyro, {.on = true, .yaw_only = yaw_only}));

    EXPECT_LT((joint.mean() - mean).cwiseAbs().maxCoeff(), 1e-9) << "seed " << kSeed << ", case " << n;
    EXPECT_LT((joint.covariance() - covariance).cwiseAbs().maxCoeff(), 1e-9) << "seed " << kSeed << ", case " << n;
    EXPECT_EQ(joint.covariance(), joint.covariance().transpose());
  }
}
INSTANTIATE_TEST_SUITE_P(Readings, JointUpdate, ::testing::Combine(::testing::Bool(), ::testing::Bool()));

TEST(GyroBias, a_reading_that_does_not_teach_is_weighed_as_if_the_bias_were_known) {
  std::mt19937 random{kSeed};
  for (int n = 0; n < 50; ++n) {
    Joint joint = random_joint(random);
    const Joint prior = joint;
    Reading reading = reading_of({kVx, kVy, kVyaw}, random);
    reading.witness.teaches_bias = false;
    const Rows H = matrix_of(reading, false, false);
    const Eigen::MatrixXd H_x = H.leftCols(kStates);
    const StateMatrix known = prior.belief.covariance.matrix() -
                              prior.bias.cross * prior.bias.covariance.inverse() * prior.bias.cross.transpose();
    const Eigen::MatrixXd K = known * H_x.transpose() * (H_x * known * H_x.transpose() + noise_of(reading)).inverse();
    const StateVector mean = prior.belief.mean + K * innovation_of(reading, H, prior.mean());
    // What of the uncertainty comes from the bias stays.
    const StateMatrix covariance =
        prior.belief.covariance.matrix() - K * (H_x * known * H_x.transpose() + noise_of(reading)) * K.transpose();

    ASSERT_TRUE(fuse(joint.belief, joint.bias, reading, false, {.on = true}));

    EXPECT_LT((joint.belief.mean - mean).cwiseAbs().maxCoeff(), 1e-9) << "seed " << kSeed << ", case " << n;
    EXPECT_LT((joint.belief.covariance.matrix() - covariance).cwiseAbs().maxCoeff(), 1e-9) << "case " << n;
    EXPECT_LT((joint.bias.cross - prior.bias.cross).cwiseAbs().maxCoeff(), 1e-9) << "case " << n;
    EXPECT_TRUE(is_positive_definite(joint.belief.covariance, joint.bias)) << "case " << n;
    EXPECT_EQ(joint.bias.mean_rps, prior.bias.mean_rps);
    EXPECT_EQ(joint.bias.covariance, prior.bias.covariance);
  }
}

TEST(GyroBias, prediction_is_that_of_the_dense_filter_of_18_states) {
  std::mt19937 random{kSeed};
  for (int n = 0; n < 20; ++n) {
    Joint joint = random_joint(random);
    const Joint prior = joint;
    JointMatrix J = JointMatrix::Identity();
    J.topLeftCorner<15, 15>() = jacobian(prior.belief.mean, 0.02);
    JointMatrix Q = JointMatrix::Zero();
    Q.bottomRightCorner<3, 3>().diagonal().setConstant(0.01 * 0.01);

    advance(joint.bias, joint.belief.mean, 0.02, {.on = true, .stddev_rps = 1e3, .drift_rps_per_sqrt_s = 0.01});
    advance(joint.belief, 0.02, ProcessNoise{});

    const JointMatrix covariance = J * prior.covariance() * J.transpose() + 0.02 * Q;
    EXPECT_LT((joint.covariance() - covariance).cwiseAbs().maxCoeff(), 1e-9) << "seed " << kSeed << ", case " << n;
  }
}

TEST(GyroBias, is_never_less_known_than_at_the_start) {
  const GyroBiasOptions options{.on = true, .stddev_rps = 0.02, .drift_rps_per_sqrt_s = 0.01};
  GyroBias bias = unknown_bias(options);
  bias.covariance *= 0.01;
  for (int n = 0; n < 1000; ++n) advance(bias, StateVector::Zero(), 0.1, options);
  EXPECT_LE(bias.covariance(2, 2), 0.02 * 0.02);
  EXPECT_GT(bias.covariance(2, 2), 0.9 * 0.02 * 0.02);
}

TEST(GyroBias, a_refused_reading_changes_nothing) {
  std::mt19937 random{kSeed};
  Joint joint = random_joint(random);
  const Joint prior = joint;
  Reading reading = reading_of({kVyaw}, random);
  reading.value[0] = 1e3;
  reading.gate = 3.0;
  const auto fused = fuse(joint.belief, joint.bias, reading, true, {.on = true});
  ASSERT_FALSE(fused);
  EXPECT_EQ(fused.error(), UpdateFault::OutsideGate);
  EXPECT_EQ(joint.mean(), prior.mean());
  EXPECT_EQ(joint.covariance(), prior.covariance());
}

TEST(GyroBias, a_belief_that_begins_with_the_gyro_knows_the_rate_no_better_than_the_bias) {
  Joint joint;
  for (int i = 0; i < kStates; ++i) joint.belief.covariance(i, i) = 1e-9;
  const GyroBiasOptions options{.on = true, .yaw_only = true, .stddev_rps = 0.02};
  joint.bias = unknown_bias(options);
  Reading first;
  first.add(kVyaw, 0.1, 1e-6);
  joint.belief.mean[kVyaw] = 0.1;
  joint.belief.covariance(kVyaw, kVyaw) = 1e-6;
  take_bias_off(joint.belief, joint.bias, first, options);
  EXPECT_DOUBLE_EQ(joint.belief.covariance(kVyaw, kVyaw), 1e-6 + 4e-4);
  EXPECT_DOUBLE_EQ(joint.bias.cross(kVyaw, 2), -4e-4);
  EXPECT_TRUE(is_positive_definite(joint.belief.covariance, joint.bias));
}

}  // namespace
}  // namespace nacelle::ekf
