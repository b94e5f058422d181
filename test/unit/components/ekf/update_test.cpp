// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/update.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "ekf/model/process_model.hpp"
#include "ekf_cases.hpp"

namespace nacelle::ekf {
namespace {

using Dynamic = Eigen::MatrixXd;

/// Where `Reading::covariance` keeps the entry of `row` and `column`.
std::size_t noise_index(int row, int column) {
  return static_cast<std::size_t>(row) * kStates + static_cast<std::size_t>(column);
}
Dynamic noise_of(const Reading& r) {
  Dynamic R(r.rows, r.rows);
  for (int k = 0; k < r.rows; ++k) {
    for (int l = 0; l < r.rows; ++l) R(k, l) = r.covariance[noise_index(k, l)];
  }
  return R;
}
Dynamic selection_of(const Reading& r) {
  Dynamic H = Dynamic::Zero(r.rows, kStates);
  for (int k = 0; k < r.rows; ++k) H(k, r.index[static_cast<std::size_t>(k)]) = 1.0;
  return H;
}

Reading random_reading(std::mt19937& random, int rows, bool correlated) {
  std::array<int, kStates> states{};
  std::iota(states.begin(), states.end(), 0);
  std::shuffle(states.begin(), states.end(), random);
  std::uniform_real_distribution<double> any{-1.0, 1.0};
  Reading r;
  for (int k = 0; k < rows; ++k) {
    r.add(static_cast<StateIndex>(states[static_cast<std::size_t>(k)]), any(random), 0.05 + std::abs(any(random)));
  }
  if (correlated) {
    Dynamic half(rows, rows);
    for (double& value : half.reshaped()) value = any(random);
    const Dynamic R = half * half.transpose() + 0.1 * Dynamic::Identity(rows, rows);
    for (int k = 0; k < rows; ++k) {
      for (int l = 0; l < rows; ++l) r.covariance[noise_index(k, l)] = R(k, l);
    }
  }
  return r;
}

Belief random_belief(std::mt19937& random) {
  Belief belief;
  belief.mean = random_state(random);
  belief.covariance = random_covariance(random);
  return belief;
}

TEST(UpdateLaws, equals_josephs_form_written_with_dense_matrices) {
  const unsigned seed = 31;
  std::mt19937 random{seed};
  for (int n = 0; n < 300; ++n) {
    const int rows = 1 + n % kStates;
    const Belief prior = random_belief(random);
    const Reading reading = random_reading(random, rows, n % 2 == 0);
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", case " << n << ", rows " << rows);

    const auto updated = update(prior, reading);

    ASSERT_TRUE(updated);
    const Dynamic P = prior.covariance.matrix(), H = selection_of(reading), R = noise_of(reading);
    const Dynamic S = H * P * H.transpose() + R;
    const Dynamic K = P * H.transpose() * S.inverse();
    const Dynamic A = Dynamic::Identity(kStates, kStates) - K * H;
    const Dynamic expected = A * P * A.transpose() + K * R * K.transpose();
    Eigen::VectorXd innovation(rows);
    for (int k = 0; k < rows; ++k) {
      const auto i = static_cast<std::size_t>(k);
      innovation[k] = reading.value[i] - prior.mean[reading.index[i]];
    }
    EXPECT_LT((updated->belief.covariance.matrix() - expected).norm(), 1e-10 * P.norm());
    EXPECT_LT((updated->belief.mean - prior.mean - K * innovation).norm(), 1e-9);
    EXPECT_NEAR(updated->fused.mahalanobis_squared, innovation.dot(S.inverse() * innovation), 1e-8);
    EXPECT_EQ(updated->belief.covariance.matrix(), updated->belief.covariance.matrix().transpose());
  }
}

TEST(UpdateLaws, no_variance_grows) {
  std::mt19937 random{32};
  for (int n = 0; n < 100; ++n) {
    const Belief prior = random_belief(random);
    const auto updated = update(prior, random_reading(random, 1 + n % kStates, true));
    ASSERT_TRUE(updated);
    for (int i = 0; i < kStates; ++i) EXPECT_LE(updated->belief.covariance(i, i), prior.covariance(i, i) * (1 + 1e-12));
  }
}

TEST(UpdateLaws, independent_readings_may_be_fused_together_or_one_by_one) {
  std::mt19937 random{33};
  for (int n = 0; n < 50; ++n) {
    const Belief prior = random_belief(random);
    const Reading together = random_reading(random, 6, false);
    Belief one_by_one = prior;
    for (std::size_t k = 0; k < 6; ++k) {
      Reading single;
      single.add(static_cast<StateIndex>(together.index[k]), together.value[k], together.covariance[k * (kStates + 1)]);
      ASSERT_TRUE(fuse(one_by_one, single));
    }
    const auto at_once = update(prior, together);
    ASSERT_TRUE(at_once);
    EXPECT_LT((at_once->belief.mean - one_by_one.mean).norm(), 1e-10);
    EXPECT_LT((at_once->belief.covariance.matrix() - one_by_one.covariance.matrix()).norm(), 1e-10);
  }
}

TEST(UpdateLaws, the_order_of_rows_does_not_matter) {
  std::mt19937 random{34};
  const Belief prior = random_belief(random);
  Reading forward, backward;
  for (int k = 0; k < 9; ++k) forward.add(static_cast<StateIndex>(k), 0.1 * k, 0.2 + k);
  for (int k = 8; k >= 0; --k) backward.add(static_cast<StateIndex>(k), 0.1 * k, 0.2 + k);
  EXPECT_LT((update(prior, forward)->belief.mean - update(prior, backward)->belief.mean).norm(), 1e-12);
}

// A linear system has a closed answer: least squares over all readings at once.
TEST(UpdateLaws, position_and_velocity_from_many_fixes_equal_the_batch_solution) {
  const unsigned seed = 35;
  std::mt19937 random{seed};
  std::normal_distribution<double> noise{0.0, 0.1};
  const double dt = 0.1, variance = 0.01;
  const int fixes = 60;
  Belief belief;
  for (int i = 0; i < kStates; ++i) belief.covariance(i, i) = 1e-9;
  belief.covariance(kX, kX) = 100.0;
  belief.covariance(kVx, kVx) = 100.0;
  Dynamic A(fixes + 2, 2);
  Eigen::VectorXd z(fixes + 2);
  A.row(fixes) << 0.1, 0.0;  // the prior, weighted by 1/sigma
  A.row(fixes + 1) << 0.0, 0.1;
  z[fixes] = z[fixes + 1] = 0.0;
  const ProcessNoise none{StateMatrix{StateMatrix::Zero()}};
  for (int i = 0; i < fixes; ++i) {
    if (i > 0) advance(belief, dt, none);
    const double fix = 2.0 + 0.7 * dt * i + noise(random);
    Reading r;
    r.add(kX, fix, variance);
    ASSERT_TRUE(fuse(belief, r));
    A.row(i) << 1.0 / 0.1, dt * i / 0.1;
    z[i] = fix / 0.1;
  }
  const Eigen::Matrix2d information = A.transpose() * A;
  const Eigen::Vector2d at_start = information.inverse() * (A.transpose() * z);
  const double end = dt * (fixes - 1);
  EXPECT_NEAR(belief.mean[kVx], at_start[1], 1e-6) << "seed " << seed;
  EXPECT_NEAR(belief.mean[kX], at_start[0] + end * at_start[1], 1e-6);
  EXPECT_NEAR(belief.covariance(kVx, kVx), information.inverse()(1, 1), 1e-8);
}

TEST(Update, wraps_the_innovation_of_angles) {
  Belief prior;
  for (int i = 0; i < kStates; ++i) prior.covariance(i, i) = 0.1;
  prior.mean[kYaw] = 3.1;
  Reading r;
  r.add(kYaw, -3.1, 0.1);
  const auto updated = update(prior, r);
  ASSERT_TRUE(updated);
  EXPECT_NEAR(std::abs(updated->belief.mean[kYaw]), 3.14159265, 1e-6);
}

TEST(Update, a_gate_is_a_distance_and_refuses_at_its_edge) {
  Belief prior;
  for (int i = 0; i < kStates; ++i) prior.covariance(i, i) = 3.0;
  Reading r;
  r.add(kX, 4.0, 1.0);  // S = 4, distance 2
  r.gate = 2.0;
  EXPECT_EQ(update(prior, r).error(), UpdateFault::OutsideGate);
  r.gate = 2.0001;
  EXPECT_TRUE(update(prior, r));
}

TEST(Update, a_fault_leaves_the_belief_as_it_was) {
  std::mt19937 random{36};
  const Belief prior = random_belief(random);
  Belief belief = prior;
  Reading nan;
  nan.add(kX, std::numeric_limits<double>::quiet_NaN(), 1.0);
  Reading infinite;
  infinite.add(kX, 1.0, std::numeric_limits<double>::infinity());
  Reading none;
  Reading impossible;  // correlation 100 between two variances of 1
  impossible.add(kX, 1.0, 1.0);
  impossible.add(kY, 1.0, 1.0);
  impossible.covariance[1] = impossible.covariance[kStates] = 100.0;

  EXPECT_EQ(fuse(belief, nan).error(), UpdateFault::NotFinite);
  EXPECT_EQ(fuse(belief, infinite).error(), UpdateFault::NotFinite);
  EXPECT_EQ(fuse(belief, none).error(), UpdateFault::NoRows);
  EXPECT_EQ(fuse(belief, impossible).error(), UpdateFault::SingularInnovation);

  EXPECT_EQ(belief.mean, prior.mean);
  EXPECT_EQ(belief.covariance.matrix(), prior.covariance.matrix());
}

TEST(Update, zero_and_negative_variances_are_raised_and_mirrored) {
  Belief prior;
  for (int i = 0; i < kStates; ++i) prior.covariance(i, i) = 1.0;
  Reading zero, negative;
  zero.add(kX, 1.0, 0.0);
  negative.add(kX, 1.0, -1.0);
  EXPECT_NEAR(update(prior, zero)->belief.covariance(kX, kX), kSmallestVariance, 1e-12);
  EXPECT_NEAR(update(prior, negative)->belief.mean[kX], 0.5, 1e-12);
}

TEST(Update, survives_a_perfect_reading_of_something_unknown) {
  std::mt19937 random{37};
  for (const double unknown : {1e3, 1e6, 1e9}) {
    Belief belief;
    belief.covariance = StateMatrix{random_covariance(random) * unknown};
    Reading r;
    for (int i = 0; i < 9; ++i) r.add(static_cast<StateIndex>(i), 0.0, 1e-9);
    const auto fused = fuse(belief, r);
    ASSERT_TRUE(fused) << unknown;
    EXPECT_TRUE(is_positive_definite(belief.covariance)) << unknown;
  }
}

struct LongCase {
  double variance;
  int steps;
};
class LongRun : public ::testing::TestWithParam<LongCase> {};

TEST_P(LongRun, the_covariance_stays_symmetric_and_positive_definite_for_ever) {
  const auto [variance, steps] = GetParam();
  const unsigned seed = 38;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any{-0.5, 0.5};
  StateMatrix Q = StateMatrix::Identity() * 0.02;
  const ProcessNoise noise{Q};
  Belief belief;
  for (int i = 0; i < kStates; ++i) belief.covariance(i, i) = 1e-9;
  belief.mean[kVx] = 0.3;
  belief.mean[kVyaw] = 0.5;
  Reading twist, rates;
  for (const StateIndex i : {kVx, kVy, kVz, kVroll, kVpitch, kVyaw, kZ, kRoll, kPitch}) twist.add(i, 0.0, variance);
  for (const StateIndex i : {kVyaw, kAx, kAy}) rates.add(i, 0.0, variance);
  for (int n = 0; n < steps; ++n) {
    advance(belief, 0.01, noise);
    twist.value[0] = 0.3 + 0.1 * any(random);
    rates.value[0] = 0.5 + 0.1 * any(random);
    ASSERT_TRUE(fuse(belief, n % 2 == 0 ? twist : rates)) << "seed " << seed << ", step " << n;
    if (n % 5000 == 0) { ASSERT_TRUE(is_positive_definite(belief.covariance)) << "seed " << seed << ", step " << n; }
  }
  EXPECT_TRUE(is_positive_definite(belief.covariance));
  EXPECT_EQ(belief.covariance.matrix(), belief.covariance.matrix().transpose());
  EXPECT_TRUE(belief.mean.allFinite());
  EXPECT_GT(belief.covariance(kX, kX), 1.0) << "nothing measures the position: it must have become unsure";
}
INSTANTIATE_TEST_SUITE_P(Variances, LongRun, ::testing::Values(LongCase{1e-9, 1'000'000}, LongCase{1e-3, 100'000}));

}  // namespace
}  // namespace nacelle::ekf
