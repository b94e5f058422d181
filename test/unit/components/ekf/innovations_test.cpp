// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/innovations.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ekf/model/process_model.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::ekf {
namespace {

WallTime after_ms(int ms) { return WallTime{1000s + ms * 1ms}; }

/// A speed that wanders as the filter believes, and one sensor of it.
struct Bench {
  double claimed_stddev = 0.1, real_stddev = 0.1, offset = 0.0;
  double acceleration_stddev = 0.0;  ///< Of a manoeuvre that the filter does not know of: steady for half a second.
  bool adaptive = false;
  unsigned seed = 71;
};
struct Outcome {
  AxisNoise noise;
  Belief belief;
  double mean_square_error{};
};
Outcome run_bench(const Bench& bench, int steps = 3000) {
  constexpr double kDt_s = 0.02, kRate = 0.05;
  std::mt19937 random{bench.seed};
  std::normal_distribution<double> normal;
  StateMatrix Q = StateMatrix::Identity() * 1e-9;
  Q(kVx, kVx) = kRate;
  const ProcessNoise noise{Q};
  Belief belief;
  belief.covariance = StateMatrix{StateMatrix::Identity() * 1e-3};
  Innovations innovations{1, {{bench.adaptive}}, 0};
  double speed = 0.0, acceleration = 0.0, square = 0.0;
  for (int i = 0; i < steps; ++i) {
    if (i % 25 == 0) acceleration = bench.acceleration_stddev * normal(random);
    speed += std::sqrt(kRate * kDt_s) * normal(random) + acceleration * kDt_s;
    advance(belief, kDt_s, noise);
    Reading reading;
    reading.add(kVx, speed + bench.offset + bench.real_stddev * normal(random),
                bench.claimed_stddev * bench.claimed_stddev);
    const Reading& used = innovations.note(0, after_ms(20 * i), belief, reading);
    EXPECT_TRUE(fuse(belief, used));
    square += (belief.mean[kVx] - speed) * (belief.mean[kVx] - speed) / steps;
  }
  return {innovations.axis(0, kVx), belief, square};
}

TEST(Innovations, of_an_honest_sensor_have_a_normalised_square_of_one) {
  const AxisNoise noise = run_bench({}).noise;
  EXPECT_NEAR(noise.nis, 1.0, 0.25);
  EXPECT_NEAR(noise.noise, 1.0, 0.25);
  EXPECT_NEAR(noise.offset, 0.0, 0.25);
  EXPECT_EQ(noise.count, 3000U);
}

TEST(Innovations, tell_how_much_noisier_a_sensor_is_than_it_claims) {
  for (const double factor : {2.0, 3.1, 8.0}) {
    const AxisNoise noise = run_bench({.claimed_stddev = 0.1, .real_stddev = 0.1 * factor}).noise;
    EXPECT_NEAR(noise.noise, factor, 0.2 * factor);
    EXPECT_GT(noise.nis, 2.0);
  }
}

TEST(Innovations, tell_that_a_sensor_is_more_precise_than_it_claims) {
  const AxisNoise noise = run_bench({.claimed_stddev = 0.5, .real_stddev = 0.05}).noise;
  EXPECT_LT(noise.noise, 0.4);
  EXPECT_LT(noise.nis, 0.7);
}

// A sensor that differs from a better one by a constant.
TEST(Innovations, do_not_take_a_bias_for_noise) {
  std::mt19937 random{72};
  std::normal_distribution<double> normal;
  Innovations innovations{1, {}, 0};
  Belief belief;
  belief.covariance = StateMatrix{StateMatrix::Identity() * 1e-6};
  for (int i = 0; i < 500; ++i) {
    Reading reading;
    reading.add(kVyaw, 0.1 + 0.01 * normal(random), 1e-4);
    (void)innovations.note(0, after_ms(10 * i), belief, reading);
  }
  const AxisNoise noise = innovations.axis(0, kVyaw);
  EXPECT_NEAR(noise.noise, 1.0, 0.2);
  EXPECT_GT(noise.nis, 50.0);
  EXPECT_GT(noise.offset, 7.0);
}

TEST(Innovations, do_not_take_a_manoeuvre_for_noise) {
  const AxisNoise noise = run_bench({.claimed_stddev = 0.05, .real_stddev = 0.05, .acceleration_stddev = 8.0}).noise;
  EXPECT_GT(noise.nis, 3.0);
  EXPECT_LT(noise.noise, 1.5);
}

TEST(Innovations, are_counted_once_when_a_filter_replays_its_history) {
  Innovations innovations{2, {}, 0};
  const Belief belief = run_bench({}, 10).belief;
  Reading reading;
  reading.add(kVx, 0.1, 0.01);
  const auto note_all = [&] {
    for (int i = 0; i < 40; ++i) (void)innovations.note(0, after_ms(20 * i), belief, reading);
  };
  note_all();
  const AxisNoise once = innovations.axis(0, kVx);
  note_all();
  EXPECT_EQ(innovations.axis(0, kVx).count, 40U);
  EXPECT_EQ(innovations.axis(0, kVx).nis, once.nis);
  EXPECT_EQ(innovations.axis(1, kVx).count, 0U);

  innovations.restart();  // the clock was set back
  note_all();
  EXPECT_EQ(innovations.axis(0, kVx).count, 80U);
}

TEST(Innovations, say_nothing_before_there_are_enough_of_them) {
  const AxisNoise early = run_bench({.real_stddev = 1.0}, static_cast<int>(Innovations::kEnough) - 1).noise;
  EXPECT_EQ(early.nis, 0.0);
  EXPECT_EQ(early.noise, 0.0);
  EXPECT_GT(run_bench({.real_stddev = 1.0}, static_cast<int>(Innovations::kEnough)).noise.nis, 0.0);
}

TEST(Innovations, leave_out_what_two_d_mode_holds) {
  Innovations innovations{1, {}, mask_of(kVz)};
  Reading reading;
  reading.add(kVz, 0.0, 1e-6);
  reading.add(kVx, 0.1, 1e-2);
  for (int i = 0; i < 50; ++i) (void)innovations.note(0, after_ms(i), Belief{}, reading);
  EXPECT_EQ(innovations.axis(0, kVz).count, 0U);
  EXPECT_EQ(innovations.axis(0, kVx).count, 50U);
}

TEST(AdaptiveNoise, makes_the_filter_as_unsure_as_it_is_wrong) {
  const Bench noisy{.claimed_stddev = 0.05, .real_stddev = 0.3};
  Bench adaptive = noisy;
  adaptive.adaptive = true;
  const Outcome without = run_bench(noisy), with = run_bench(adaptive);
  EXPECT_NEAR(with.noise.scale, 6.0, 1.2);
  EXPECT_EQ(without.noise.scale, 1.0);
  EXPECT_LT(with.mean_square_error, 0.5 * without.mean_square_error);
  const double nees = with.mean_square_error / with.belief.covariance(kVx, kVx);
  EXPECT_NEAR(nees, 1.0, 0.5);
  EXPECT_GT(without.mean_square_error / without.belief.covariance(kVx, kVx), 5.0);
}

TEST(AdaptiveNoise, is_bounded_and_never_lowers_what_a_sensor_claims) {
  EXPECT_EQ(run_bench({.claimed_stddev = 0.001, .real_stddev = 1.0, .adaptive = true}).noise.scale,
            Innovations::kMostScale);
  EXPECT_EQ(run_bench({.claimed_stddev = 1.0, .real_stddev = 0.01, .adaptive = true}).noise.scale, 1.0);
}

TEST(AdaptiveNoise, keeps_a_covariance_a_covariance) {
  Innovations innovations{1, {{true}}, 0};
  Belief belief;
  belief.covariance = StateMatrix{StateMatrix::Identity() * 1e-6};
  std::mt19937 random{73};
  std::normal_distribution<double> normal;
  Reading reading;
  for (int i = 0; i < 200; ++i) {
    reading.rows = 0;
    reading.add(kVx, normal(random), 0.04);
    reading.add(kVy, 0.05 * normal(random), 0.01);
    reading.covariance[1] = reading.covariance[kStates] = 0.019;  // correlation 0.95
    const Reading& used = innovations.note(0, after_ms(i), belief, reading);
    const double determinant =
        used.covariance[0] * used.covariance[kStates + 1] - used.covariance[1] * used.covariance[kStates];
    ASSERT_GT(determinant, 0.0);
    ASSERT_EQ(used.covariance[1], used.covariance[kStates]);
  }
  EXPECT_GT(innovations.axis(0, kVx).scale, 3.0);
  EXPECT_EQ(innovations.axis(0, kVy).scale, 1.0);
}

TEST(Innovations, allocate_nothing) {
  Innovations innovations{1, {{true}}, 0};
  Reading reading;
  reading.add(kVx, 0.3, 1e-4);
  const Belief belief;
  const test::AllocationGuard guard;
  for (int i = 0; i < 100; ++i) (void)innovations.note(0, after_ms(i), belief, reading);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace nacelle::ekf
