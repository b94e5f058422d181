// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "imu_filter/model/complementary_filter.hpp"
#include "imu_filter/model/madgwick_filter.hpp"

namespace nacelle::imu_filter {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kGravityMps2 = 9.80665;

enum class Kind : std::uint8_t { Madgwick, Complementary };

std::unique_ptr<OrientationFilter> make(Kind kind, const WorldFrame& world = WorldFrame::enu()) {
  if (kind == Kind::Madgwick) return std::make_unique<MadgwickFilter>(world, MadgwickFilter::Settings{});
  return std::make_unique<ComplementaryFilter>(world, ComplementaryFilter::Settings{});
}

/// A sensor that turns about all axes in a smooth, seeded way, as REP 145 describes what it reads.
class TurningSensor {
 public:
  TurningSensor(unsigned seed, WorldFrame world) : world_(std::move(world)), random_(seed) {
    for (auto& wave : waves_) wave = {uniform(0.2, 0.8), uniform(0.5, 2.0), uniform(0.0, 6.28)};
  }
  /// Central Europe's field: 48 uT, 65 degrees below the horizon.
  Eigen::Vector3d field_W() const {
    return 48e-6 * (std::cos(65 * kDeg) * world_.north - std::sin(65 * kDeg) * world_.up);
  }
  Measurement step(double dt_s) {
    // Ten small turns a reading: the truth is finer than what the filter sees.
    for (int i = 0; i < 10; ++i) {
      t_s_ += dt_s / 10;
      const Eigen::Vector3d half = 0.5 * rate() * dt_s / 10;
      R_WS_ =
          (R_WS_ * Eigen::Quaterniond{std::sqrt(1 - half.squaredNorm()), half.x(), half.y(), half.z()}).normalized();
    }
    Measurement m{.dt_s = dt_s};
    m.angular_velocity_rps = rate() + gyro_bias_rps + noise(gyro_noise_rps);
    m.acceleration_mps2 = R_WS_.conjugate() * (kGravityMps2 * world_.up) + noise(0.02);
    m.magnetic_field = R_WS_.conjugate() * field_W() + hard_iron_t + noise(0.3e-6);
    return m;
  }
  const Eigen::Quaterniond& truth() const { return R_WS_; }
  double heading_error_deg(const Eigen::Quaterniond& estimate) const {
    const Eigen::Quaterniond apart = estimate * R_WS_.conjugate();
    return 2.0 * std::atan2(apart.vec().dot(world_.up), apart.w()) / kDeg;
  }

  double speed = 1.0;
  double gyro_noise_rps = 0.002;
  Eigen::Vector3d gyro_bias_rps{0, 0, 0};
  Eigen::Vector3d hard_iron_t{0, 0, 0};

 private:
  struct Wave {
    double rps, omega, phase;
  };
  double uniform(double from, double to) { return std::uniform_real_distribution<double>{from, to}(random_); }
  Eigen::Vector3d noise(double stddev) {
    std::normal_distribution<double> draw{0.0, stddev};
    return {draw(random_), draw(random_), draw(random_)};
  }
  Eigen::Vector3d rate() const {
    Eigen::Vector3d rate;
    for (int i = 0; i < 3; ++i) {
      const auto& wave = waves_[static_cast<std::size_t>(i)];
      rate[i] = speed * wave.rps * std::sin(wave.omega * t_s_ + wave.phase);
    }
    return rate;
  }

  WorldFrame world_;
  std::mt19937 random_;
  std::array<Wave, 3> waves_{};
  Eigen::Quaterniond R_WS_{0.8, 0.1, -0.2, 0.5656854};
  double t_s_ = 0.0;
};

class EveryFilter : public ::testing::TestWithParam<Kind> {};

TEST_P(EveryFilter, starts_with_the_truth_in_each_world_frame) {
  for (const auto& world : {WorldFrame::enu(), WorldFrame::nwu(), WorldFrame::ned()}) {
    TurningSensor sensor{3, world};
    const auto filter = make(GetParam(), world);
    const Measurement m = sensor.step(0.01);
    ASSERT_TRUE(filter->start(m));
    EXPECT_LT(filter->orientation().angularDistance(sensor.truth()) / kDeg, 2.5);
  }
}

TEST_P(EveryFilter, without_a_field_the_start_points_along_x_of_the_world) {
  const auto filter = make(GetParam());
  Measurement m;
  m.acceleration_mps2 = {0.0, 3.0, 9.0};
  ASSERT_TRUE(filter->start(m));
  const Eigen::Vector3d x_W = filter->orientation() * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(x_W.x(), 1.0, 1e-12);
  EXPECT_NEAR((filter->orientation() * m.acceleration_mps2.normalized()).z(), 1.0, 1e-12);
}

TEST_P(EveryFilter, does_not_start_in_free_fall) { EXPECT_FALSE(make(GetParam())->start({})); }

TEST_P(EveryFilter, follows_turns_about_all_axes_within_two_degrees) {
  const unsigned seed = 17;
  for (const auto& world : {WorldFrame::enu(), WorldFrame::nwu(), WorldFrame::ned()}) {
    TurningSensor sensor{seed, world};
    const auto filter = make(GetParam(), world);
    ASSERT_TRUE(filter->start(sensor.step(0.01)));
    double worst_deg = 0.0;
    for (int i = 0; i < 6000; ++i) {
      filter->update(sensor.step(0.01));
      if (i > 500) worst_deg = std::max(worst_deg, filter->orientation().angularDistance(sensor.truth()) / kDeg);
    }
    EXPECT_LT(worst_deg, 2.0) << "seed " << seed;
    EXPECT_NEAR(filter->orientation().norm(), 1.0, 1e-12);
  }
}

TEST_P(EveryFilter, the_field_holds_the_heading_that_a_biased_gyro_loses) {
  TurningSensor with{29, WorldFrame::enu()}, without{29, WorldFrame::enu()};
  with.gyro_bias_rps = without.gyro_bias_rps = {0.002, -0.003, 0.004};
  const auto nine = make(GetParam()), six = make(GetParam());
  const Measurement first = with.step(0.01);
  without.step(0.01);
  ASSERT_TRUE(nine->start(first));
  ASSERT_TRUE(six->start(first));
  double squares = 0.0;
  for (int i = 0; i < 12000; ++i) {
    nine->update(with.step(0.01));
    Measurement m = without.step(0.01);
    m.magnetic_field.reset();
    six->update(m);
    const double error = with.heading_error_deg(nine->orientation());
    squares += error * error;
  }
  const double rms_deg = std::sqrt(squares / 12000);
  const double lost_deg = std::abs(without.heading_error_deg(six->orientation()));
  std::printf("heading over 120 s: %.2f deg RMS with the field, %.1f deg lost without\n", rms_deg, lost_deg);
  EXPECT_LT(rms_deg, 1.0);
  EXPECT_GT(lost_deg, 10.0);
}

TEST_P(EveryFilter, a_reading_without_acceleration_turns_with_the_gyro_alone) {
  const auto filter = make(GetParam());
  filter->start_at(Eigen::Quaterniond::Identity());
  Measurement m{.dt_s = 0.01};
  m.angular_velocity_rps = {0.0, 0.0, std::numbers::pi / 2};
  for (int i = 0; i < 100; ++i) filter->update(m);
  const Eigen::Vector3d x_W = filter->orientation() * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(x_W.y(), 1.0, 1e-9);
}

TEST_P(EveryFilter, levelling_mends_the_tilt_and_keeps_the_heading) {
  const auto filter = make(GetParam());
  filter->start_at(Eigen::Quaterniond{Eigen::AngleAxisd{1.0, Eigen::Vector3d::UnitZ()}} *
                   Eigen::Quaterniond{Eigen::AngleAxisd{0.4, Eigen::Vector3d::UnitX()}});
  filter->level({0.0, 0.0, 9.8});
  const Eigen::Quaterniond expected{Eigen::AngleAxisd{1.0, Eigen::Vector3d::UnitZ()}};
  EXPECT_LT(filter->orientation().angularDistance(expected), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Filters, EveryFilter, ::testing::Values(Kind::Madgwick, Kind::Complementary));

TEST(MadgwickFilter, learns_the_bias_of_the_gyro_with_zeta) {
  TurningSensor sensor{5, WorldFrame::enu()};
  sensor.gyro_bias_rps = {0.01, -0.02, 0.015};
  MadgwickFilter filter{WorldFrame::enu(), {.gain = 0.1, .zeta = 0.01}};
  ASSERT_TRUE(filter.start(sensor.step(0.01)));
  for (int i = 0; i < 20000; ++i) filter.update(sensor.step(0.01));
  EXPECT_LT((filter.bias_rps() - sensor.gyro_bias_rps).cwiseAbs().maxCoeff(), 0.004);
}

TEST(ComplementaryFilter, learns_the_bias_at_rest_and_not_in_motion) {
  TurningSensor still{6, WorldFrame::enu()}, moving{6, WorldFrame::enu()};
  still.gyro_bias_rps = moving.gyro_bias_rps = {0.01, -0.02, 0.015};
  still.speed = 0.0;
  ComplementaryFilter at_rest{WorldFrame::enu(), {}}, in_motion{WorldFrame::enu(), {}};
  ASSERT_TRUE(at_rest.start(still.step(0.01)));
  ASSERT_TRUE(in_motion.start(moving.step(0.01)));
  for (int i = 0; i < 1000; ++i) {
    at_rest.update(still.step(0.01));
    Measurement m = moving.step(0.01);
    m.acceleration_mps2.x() += 3.0 * std::sin(i);  // shaken
    in_motion.update(m);
  }
  EXPECT_LT((at_rest.bias_rps() - still.gyro_bias_rps).cwiseAbs().maxCoeff(), 0.001);
  EXPECT_LT(in_motion.bias_rps().norm(), at_rest.bias_rps().norm());
}

TEST(ComplementaryFilter, a_hard_push_does_not_tilt_it) {
  const auto run = [](bool adaptive) {
    ComplementaryFilter filter{WorldFrame::enu(), {.gain_acc = 0.05, .do_adaptive_gain = adaptive}};
    filter.start_at(Eigen::Quaterniond::Identity());
    Measurement m{.dt_s = 0.01};
    m.acceleration_mps2 = {8.0, 0.0, kGravityMps2};
    for (int i = 0; i < 50; ++i) filter.update(m);
    return filter.orientation().angularDistance(Eigen::Quaterniond::Identity()) / kDeg;
  };
  EXPECT_LT(run(true), 1e-9);
  EXPECT_GT(run(false), 20.0);
}

}  // namespace
}  // namespace nacelle::imu_filter
