// SPDX-License-Identifier: Apache-2.0
// Laws that hold for any stream of measurements.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "ekf_cases.hpp"
#include "late_cases.hpp"

namespace nacelle::ekf {
namespace {

/// Measurements of a second with any stamps, some of them equal; each is a part of its own, so that they may come in any order. Every
/// third is of wheels, every third of an IMU.
std::vector<Told> any_measurements(std::mt19937& random, std::uint16_t count) {
  std::uniform_int_distribution<int> when{0, 199};
  std::uniform_int_distribution<int> rows{1, 6};
  std::uniform_real_distribution<double> any{-1.0, 1.0};
  std::vector<Told> told;
  for (std::uint16_t part = 0; part < count; ++part) {
    Told& t = told.emplace_back(Told{5ms * when(random), {}, part, {}});
    std::array<int, kStates> states{};
    std::iota(states.begin(), states.end(), 0);
    std::shuffle(states.begin(), states.end(), random);
    const int n = rows(random);
    for (int k = 0; k < n; ++k)
      t.reading.add(static_cast<StateIndex>(states[static_cast<std::size_t>(k)]), 0.3 * any(random),
                    0.01 + 0.05 * std::abs(any(random)));
    if (part % 3 == 0) t.reading.witness.source = Witness::Source::Wheels;
    if (part % 3 == 1) t.reading.witness.source = Witness::Source::Imu;
    t.reading.witness.linear = {0.3 * any(random), 0.0, 9.8};
    t.reading.witness.angular = {0.0, 0.0, 0.3 * any(random)};
  }
  return told;
}

struct Switches {
  bool predicts, dynamic;
  std::int64_t replay_instructions;
  bool assists{false};
};
class AnyOrder : public ::testing::TestWithParam<Switches> {};

TEST_P(AnyOrder, of_stamps_within_the_history_gives_the_same_state) {
  constexpr std::uint16_t kCount = 60;
  constexpr Duration kEnd = 3s;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random{seed};
    std::vector<Told> told = any_measurements(random, kCount);
    FilterOptions o = late_options(kCount + 1, 4s);
    o.predict_to_current_time = GetParam().predicts;
    o.dynamic_process_noise = GetParam().dynamic;
    o.replay_instructions = GetParam().replay_instructions;
    o.assists.gyro_bias.on = o.assists.standstill.on = o.assists.slip.on = GetParam().assists;
    std::uniform_int_distribution<int> later{0, 1000};
    const auto state_of = [&](bool in_order) {
      Filter filter{o};
      for (Told& t : told) t.arrives = in_order ? t.stamp : t.stamp + 1ms * later(random);
      if (!in_order) std::shuffle(told.begin(), told.end(), random);
      std::vector<Told> all = told;
      // The first comes in time: a long silence behind a late one is a clock that was set (ADR 0023). The last undoes what was
      // predicted in the silence before it.
      all.emplace_back(Told{0s, 0s, kCount, {}}).reading.add(kYaw, 0.3, 0.01);
      all.emplace_back(Told{kEnd, kEnd, kCount, {}}).reading.add(kVx, 0.3, 0.01);
      run_filter(filter, all, kEnd);
      std::uint64_t fused = 0;
      for (std::size_t part = 0; part <= kCount; ++part) fused += filter.stats(part).fused;
      EXPECT_EQ(fused, kCount + 2) << "seed " << seed;
      EXPECT_FALSE(filter.history()->pending());
      EXPECT_TRUE(is_positive_definite(filter.belief().covariance));
      return std::pair{filter.stamp(), filter.belief()};
    };
    const auto first = state_of(true);
    for (int order = 0; order < 3; ++order) {
      const auto other = state_of(false);
      ASSERT_EQ(first.first, other.first) << "seed " << seed;
      ASSERT_LT(difference(first.second, other.second), 1e-9) << "seed " << seed << ", order " << order;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Switches, AnyOrder,
                         ::testing::Values(Switches{false, false, 1'500'000}, Switches{true, false, 1'500'000},
                                           Switches{false, true, 1'500'000}, Switches{true, true, 100'000},
                                           Switches{false, false, 1'500'000, true}));

TEST(AnyOrderAtOnce, of_arrival_within_one_step_does_not_matter_even_for_the_first_stamp) {
  std::mt19937 random{7};
  for (int round = 0; round < 50; ++round) {
    std::vector<Told> told = any_measurements(random, 8);
    for (Told& t : told) t.stamp = 5ms * (t.part / 4);  // two stamps
    const auto state_of = [&] {
      Filter filter{late_options(8, 1s)};
      run_filter(filter, told, 20ms);
      return filter.belief();
    };
    for (Told& t : told) t.arrives = 10ms;
    const Belief first = state_of();
    std::shuffle(told.begin(), told.end(), random);
    ASSERT_EQ(first.mean, state_of().mean) << "round " << round << ", bit by bit";
  }
}

// The world turned by an angle about its z axis and moved: the same drive, seen from elsewhere.
TEST(WorldFrame, a_turned_and_moved_world_turns_and_moves_the_estimate) {
  std::uniform_real_distribution<double> any{-1.0, 1.0};
  for (const bool smooths : {false, true}) {
    for (unsigned seed = 1; seed <= 30; ++seed) {
      std::mt19937 random{seed};
      const double turn = 3.0 * any(random);
      const Eigen::Vector3d shift{5.0 * any(random), 5.0 * any(random), any(random)};
      const RigidTransform X_VW{spatial::quaternion_from_rpy({0.0, 0.0, turn}), shift};
      const FilterOptions o = late_options(2, smooths ? std::optional<Duration>{1s} : std::nullopt);
      Filter here{o};
      Filter there{o};
      for (int i = 0; i < 100; ++i) {
        const WallTime now = kLateStart + 20ms * i;
        const double s = 0.02 * i;
        const RigidTransform X_WB{
            spatial::quaternion_from_rpy({0.1 * std::sin(s), 0.1 * std::cos(s), 1.5 * s + 0.02 * any(random)}),
            {std::sin(s) + 0.02 * any(random), 1.0 - std::cos(s), 0.1 * any(random)}};
        // A covariance of roll, pitch and yaw is turned with the world like a vector (robot_localization, preparePose), which roll and
        // pitch are not: one that is round does not show it.
        Eigen::Matrix3d half;
        for (double& value : half.reshaped()) value = 0.1 * any(random);
        Matrix6d covariance = Matrix6d::Identity() * 0.01;
        covariance.topLeftCorner<3, 3>() += half * half.transpose();
        covariance(5, 5) = 0.003;
        Vector6d twist;
        twist << 1.0 + 0.1 * any(random), 0.1 * any(random), 0.1 * any(random), 0.1, 0.1 * any(random), 1.5;
        const Duration late = smooths && i > 10 && i % 3 != 0 ? 130ms : 0ms;
        for (Filter* filter : {&here, &there}) {
          const RigidTransform world = filter == &here ? RigidTransform{} : X_VW;
          filter->offer(0, now - late, now,
                        [&](Reading& r) { return prepare_pose(X_WB, covariance, world, {.mask = kPoseMask}, r); });
          filter->offer(1, now, now, [&](Reading& r) {
            return prepare_twist(twist, Matrix6d::Identity() * 0.01, {}, Eigen::Vector3d::Zero(), {.mask = kTwistMask},
                                 r);
          });
          filter->step(now, MonotonicTime{1s + 20ms * i});
        }
      }
      StateMatrix J = StateMatrix::Identity();
      J.block<3, 3>(kX, kX) = X_VW.rotation.toRotationMatrix();
      StateVector expected = J * here.belief().mean;
      expected.head<3>() += shift;
      expected[kYaw] += turn;
      StateVector gap = there.belief().mean - expected;
      gap[kYaw] = spatial::wrap_to_pi(gap[kYaw]);
      ASSERT_LT(gap.cwiseAbs().maxCoeff(), 1e-9) << "seed " << seed << ", smooths " << smooths << "\n"
                                                 << gap.transpose();
      const StateMatrix P = J * here.belief().covariance.matrix() * J.transpose();
      ASSERT_LT((there.belief().covariance.matrix() - P).cwiseAbs().maxCoeff(), 1e-9) << "seed " << seed;
    }
  }
}

TEST(LongRunWithHistory, with_late_measurements_the_covariance_stays_symmetric_and_positive_definite) {
  FilterOptions o = late_options(3, 500ms);
  Filter filter{o};
  std::mt19937 random{39};
  std::uniform_real_distribution<double> any{-0.5, 0.5};
  const auto offer = [&](std::uint16_t part, WallTime stamp, WallTime now, auto&& fill) {
    filter.offer(part, stamp, now, [&](Reading& r) -> Prepared {
      r.rows = 0;
      fill(r);
      return {};
    });
  };
  std::uint64_t processed = 0;
  int step = 0;
  for (; processed < 1'000'000; ++step) {
    const WallTime now = kLateStart + 20ms * step;
    offer(0, now, now, [&](Reading& r) {
      r.add(kVx, 0.3 + 0.1 * any(random), 1e-9);
      r.add(kVy, 0.0, 1e-9);
      for (const StateIndex i : {kZ, kRoll, kPitch, kVz, kVroll, kVpitch, kAz}) r.add(i, 0.0, 1e-6);
    });
    offer(1, now - 10ms, now, [&](Reading& r) { r.add(kVyaw, 0.5 + 0.1 * any(random), 1e-6); });
    if (step % 5 == 0) {
      offer(2, now - 210ms, now, [&](Reading& r) {
        r.add(kX, any(random), 1e-3);
        r.add(kY, any(random), 1e-3);
      });
    }
    filter.step(now, MonotonicTime{1s + 20ms * step});
    processed = filter.replays().measurements + filter.stats(0).fused;
    if (step % 5000 == 0 && filter.initialised()) {
      ASSERT_TRUE(is_positive_definite(filter.belief().covariance)) << "step " << step;
    }
  }
  EXPECT_GT(filter.replays().passes, 20'000U);
  EXPECT_TRUE(is_positive_definite(filter.belief().covariance));
  EXPECT_EQ(filter.belief().covariance.matrix(), filter.belief().covariance.matrix().transpose());
  EXPECT_TRUE(filter.belief().mean.allFinite());
  EXPECT_TRUE(adds_up(filter, 3));
}

}  // namespace
}  // namespace nacelle::ekf
