// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/process_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ekf/model/update.hpp"
#include "ekf_cases.hpp"
#include "nacelle/spatial/rotation.hpp"

namespace nacelle::ekf {
namespace {

TEST(ProcessModel, the_jacobian_is_the_slope_of_the_motion) {
  const unsigned seed = 15;
  std::mt19937 random{seed};
  for (int n = 0; n < 50; ++n) {
    const StateVector x = random_state(random);
    const double dt = 0.05;
    const StateMatrix J = jacobian(x, dt);
    const double h = 1e-6;
    for (int j = 0; j < kStates; ++j) {
      StateVector up = x, down = x;
      up[j] += h;
      down[j] -= h;
      const StateVector slope = (propagate(up, dt) - propagate(down, dt)) / (2 * h);
      EXPECT_LT((slope - J.col(j)).norm(), 1e-8)
          << "seed " << seed << ", case " << n << ", column " << kStateNames[static_cast<std::size_t>(j)];
    }
  }
}

TEST(ProcessModel, the_structured_prediction_equals_the_dense_products) {
  const unsigned seed = 16;
  std::mt19937 random{seed};
  for (int n = 0; n < 50; ++n) {
    Belief from;
    from.mean = random_state(random);
    const StateMatrix P = random_covariance(random);
    const StateMatrix Q = random_covariance(random);
    from.covariance = P;
    const double dt = 0.03;
    const StateMatrix J = jacobian(from.mean, dt);

    const Belief to = predict(from, dt, ProcessNoise{Q});

    const StateMatrix expected = J * P * J.transpose() + dt * Q;
    EXPECT_LT((to.covariance.matrix() - expected).norm(), 1e-12 * expected.norm()) << "seed " << seed << ", case " << n;
    EXPECT_EQ(to.covariance.matrix(), to.covariance.matrix().transpose());
    EXPECT_LT((to.mean - propagate(from.mean, dt)).norm(), 1e-15);
  }
}

TEST(ProcessModel, a_diagonal_noise_is_the_same_noise) {
  std::mt19937 random{17};
  Belief from;
  from.mean = random_state(random);
  from.covariance = random_covariance(random);
  StateMatrix Q = StateMatrix::Identity() * 0.2;
  Q(3, 3) = 0.7;
  ProcessNoise dense{Q};
  EXPECT_TRUE(dense.diagonal);
  dense.diagonal = false;
  EXPECT_EQ(predict(from, 0.1, ProcessNoise{Q}).covariance.matrix(), predict(from, 0.1, dense).covariance.matrix());
}

TEST(ProcessModel, moves_along_the_axes_of_the_body) {
  std::mt19937 random{18};
  for (int n = 0; n < 50; ++n) {
    const StateVector x = random_state(random);
    const double dt = 0.2;
    const Eigen::Matrix3d R = spatial::matrix_from_rpy({x[kRoll], x[kPitch], x[kYaw]});
    const Eigen::Vector3d step = x.segment<3>(kVx) * dt + 0.5 * dt * dt * x.segment<3>(kAx);
    const StateVector to = propagate(x, dt);
    EXPECT_LT((to.head<3>() - x.head<3>() - R * step).norm(), 1e-14);
    EXPECT_LT((to.segment<3>(kVx) - x.segment<3>(kVx) - dt * x.segment<3>(kAx)).norm(), 1e-15);
  }
}

TEST(ProcessModel, turns_at_the_rates_of_the_body) {
  std::mt19937 random{19};
  for (int n = 0; n < 50; ++n) {
    const StateVector x = random_state(random);
    const double dt = 1e-6;
    const StateVector to = propagate(x, dt);
    const Eigen::Quaterniond q0 = spatial::quaternion_from_rpy({x[kRoll], x[kPitch], x[kYaw]});
    const Eigen::Quaterniond q1 = spatial::quaternion_from_rpy({to[kRoll], to[kPitch], to[kYaw]});
    const Eigen::Vector3d rate = 2.0 * (q0.conjugate() * q1).vec() / dt;
    EXPECT_LT((rate - x.segment<3>(kVroll)).norm(), 1e-5);
  }
}

TEST(ProcessModel, a_quarter_turn_in_small_steps_ends_on_the_circle) {
  StateVector x = StateVector::Zero();
  x[kVx] = 1.0;
  x[kVyaw] = 1.0;
  const int steps = 20000;
  for (int i = 0; i < steps; ++i) x = propagate(x, spatial::kPi / 2 / steps);
  EXPECT_NEAR(x[kX], 1.0, 1e-4);
  EXPECT_NEAR(x[kY], 1.0, 1e-4);
  EXPECT_NEAR(x[kYaw], spatial::kPi / 2, 1e-12);
}

TEST(ProcessModel, angles_stay_wrapped) {
  StateVector x = StateVector::Zero();
  x[kYaw] = 3.1;
  x[kVyaw] = 1.0;
  EXPECT_NEAR(propagate(x, 0.1)[kYaw], 3.2 - 2 * spatial::kPi, 1e-12);
}

TEST(ProcessModel, dynamic_noise_leaves_a_standing_robot_sure_of_its_pose) {
  const ProcessNoise noise{StateMatrix{StateMatrix::Identity()}};
  StateVector x = StateVector::Zero();
  EXPECT_EQ(scaled_by_velocity(noise, x).rate(kX, kX), 0.0);
  EXPECT_EQ(scaled_by_velocity(noise, x).rate(kVx, kVx), 1.0);
  x[kVx] = 2.0;
  EXPECT_DOUBLE_EQ(scaled_by_velocity(noise, x).rate(kYaw, kYaw), 4.0);
}

}  // namespace
}  // namespace nacelle::ekf
