// SPDX-License-Identifier: Apache-2.0
#include "nacelle/spatial/rigid_transform.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle::spatial {
namespace {

class GroupLaws : public ::testing::Test {
 protected:
  static constexpr unsigned kSeed = 20261121;
  RigidTransform any() {
    std::normal_distribution<double> normal;
    return {Eigen::Quaterniond{normal(random_), normal(random_), normal(random_), normal(random_)}.normalized(),
            {normal(random_), normal(random_), normal(random_)}};
  }
  static double distance(const RigidTransform& a, const RigidTransform& b) {
    return (a.isometry().matrix() - b.isometry().matrix()).norm();
  }
  std::mt19937 random_{kSeed};
};

TEST_F(GroupLaws, composition_is_associative) {
  for (int i = 0; i < 200; ++i) {
    const auto A = any(), B = any(), C = any();
    EXPECT_LT(distance((A * B) * C, A * (B * C)), 1e-13) << "seed " << kSeed << ", case " << i;
  }
}

TEST_F(GroupLaws, the_inverse_undoes_from_both_sides) {
  for (int i = 0; i < 200; ++i) {
    const auto A = any();
    EXPECT_LT(distance(A * A.inverse(), {}), 1e-13) << "seed " << kSeed << ", case " << i;
    EXPECT_LT(distance(A.inverse() * A, {}), 1e-13) << "seed " << kSeed << ", case " << i;
  }
}

TEST_F(GroupLaws, it_is_the_same_group_as_eigens_isometries) {
  for (int i = 0; i < 200; ++i) {
    const auto A = any(), B = any();
    EXPECT_LT(((A * B).isometry().matrix() - (A.isometry() * B.isometry()).matrix()).norm(), 1e-13);
    EXPECT_LT(distance(RigidTransform::from(A.isometry()), A), 1e-13);
    const Eigen::Vector3d p = any().translation_m;
    EXPECT_LT((A * p - A.isometry() * p).norm(), 1e-13);
  }
}

TEST_F(GroupLaws, adjoints_multiply_as_their_transforms_do) {
  for (int i = 0; i < 100; ++i) {
    const auto A = any(), B = any();
    EXPECT_LT((adjoint(A * B) - adjoint(A) * adjoint(B)).norm(), 1e-12);
    EXPECT_LT((adjoint(A.inverse()) - adjoint(A).inverse()).norm(), 1e-12);
  }
}

TEST_F(GroupLaws, the_adjoint_is_the_velocity_of_a_point_of_the_turning_body) {
  // A body turns with w about the origin of B and moves with v; the point at A's origin, p in B, moves with v + w x p.
  const auto X_AB = any();
  Vector6d twist_B;
  twist_B << 0.3, -0.2, 0.1, 0.5, 0.7, -0.4;
  const Eigen::Vector3d p_B = X_AB.inverse() * Eigen::Vector3d{0, 0, 0};
  const Eigen::Vector3d v_B = twist_B.head<3>() + twist_B.tail<3>().cross(p_B);
  const Vector6d twist_A = adjoint(X_AB) * twist_B;
  EXPECT_LT((twist_A.head<3>() - X_AB.rotation * v_B).norm(), 1e-13);
  EXPECT_LT((twist_A.tail<3>() - X_AB.rotation * twist_B.tail<3>()).norm(), 1e-13);
}

TEST_F(GroupLaws, a_rotated_covariance_keeps_its_trace_and_its_eigenvalues) {
  std::normal_distribution<double> normal;
  for (int i = 0; i < 50; ++i) {
    Matrix6d half;
    for (double& value : half.reshaped()) value = normal(random_);
    const Matrix6d C = half * half.transpose();
    const Eigen::Matrix3d R = any().rotation.toRotationMatrix();
    const Matrix6d turned = rotate_covariance(R, C);
    // Six power sums give the six eigenvalues (Newton's identities).
    Matrix6d power = C, power_turned = turned;
    for (int k = 1; k <= 6; ++k) {
      EXPECT_NEAR(power_turned.trace(), power.trace(), 1e-11 * power.trace()) << "seed " << kSeed << ", case " << i;
      power = power * C;
      power_turned = power_turned * turned;
    }
    EXPECT_LT((rotate_covariance(R.transpose(), turned) - C).norm(), 1e-11);
  }
}

TEST(Interpolate, goes_straight_and_turns_at_a_constant_rate) {
  const auto from = RigidTransform::planar(0, 0, 0);
  const auto to = RigidTransform::planar(2, 4, 1);
  const auto half = interpolate(from, to, 0.25);
  EXPECT_NEAR(half.translation_m.x(), 0.5, 1e-15);
  EXPECT_NEAR(half.translation_m.y(), 1.0, 1e-15);
  EXPECT_NEAR(yaw_from_quaternion(half.rotation), 0.25, 1e-12);
}

}  // namespace
}  // namespace nacelle::spatial
