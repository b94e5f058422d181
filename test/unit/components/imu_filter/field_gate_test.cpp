// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/model/field_gate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <random>

#include "imu_filter/model/complementary_filter.hpp"
#include "imu_filter/model/madgwick_filter.hpp"

namespace nacelle::imu_filter {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();
using Verdict = FieldGate::Verdict;

// 48 uT, 65 degrees below the horizon, as in Central Europe.
Eigen::Vector3d earth() { return 48e-6 * Eigen::Vector3d{0.0, std::cos(65 * kDegree), -std::sin(65 * kDegree)}; }

FieldGateOptions strict() {
  FieldGateOptions options;
  options.strength_tolerance_t = 2e-6;
  options.dip_tolerance_rad = 0.05;
  return options;
}

class FieldGateTest : public ::testing::Test {
 protected:
  Verdict tell(const Eigen::Vector3d& field, std::optional<Eigen::Vector3d> up = kUp) {
    return gate_.judge(now_ += 20ms, field, up);
  }
  void learn() {
    for (int i = 0; i < 60; ++i) ASSERT_EQ(tell(earth()), Verdict::Fits);
    ASSERT_TRUE(gate_.reference());
  }
  FieldGate gate_{strict()};
  WallTime now_{100s};
};

TEST_F(FieldGateTest, learns_the_reference_in_the_first_second) {
  learn();
  EXPECT_NEAR(gate_.reference()->strength_t, 48e-6, 1e-9);
  EXPECT_NEAR(gate_.reference()->dip_rad, 65 * kDegree, 1e-6);
}

TEST_F(FieldGateTest, refuses_another_strength_and_another_dip) {
  learn();
  EXPECT_EQ(tell(1.2 * earth()), Verdict::WrongStrength);
  EXPECT_EQ(tell(0.8 * earth()), Verdict::WrongStrength);
  EXPECT_EQ(tell(Eigen::AngleAxisd{0.2, Eigen::Vector3d::UnitX()} * earth()), Verdict::WrongDip);
  EXPECT_EQ(tell(Eigen::AngleAxisd{2.0, kUp} * earth()), Verdict::Fits) << "another heading is no other dip";
}

TEST_F(FieldGateTest, measures_the_dip_from_where_up_is) {
  learn();
  const Eigen::Quaterniond tilt{Eigen::AngleAxisd{0.7, Eigen::Vector3d{1, 2, 3}.normalized()}};
  EXPECT_EQ(tell(tilt * earth(), tilt * kUp), Verdict::Fits);
}

TEST_F(FieldGateTest, without_up_the_strength_alone_counts) {
  learn();
  EXPECT_EQ(tell(Eigen::AngleAxisd{0.5, Eigen::Vector3d::UnitX()} * earth(), std::nullopt), Verdict::Fits);
}

TEST_F(FieldGateTest, a_wrong_reference_silences_the_sensor_for_the_patience_at_most) {
  FieldGateOptions options = strict();
  options.reference = FieldShape{30e-6, 0.3};
  gate_ = FieldGate{options};
  int refused = 0;
  while (tell(earth()) != Verdict::Fits) ++refused;
  EXPECT_EQ(refused, 500) << "10 s of 50 Hz";
  EXPECT_EQ(gate_.adoptions(), 1U);
  EXPECT_NEAR(gate_.second()->strength_t, 48e-6, 1e-9);
  EXPECT_EQ(tell(earth()), Verdict::Fits);
}

TEST_F(FieldGateTest, fields_that_change_are_never_adopted) {
  learn();
  for (int i = 0; i < 2000; ++i) {
    const double strength = 1.5 + 0.4 * std::sin(0.05 * i);
    ASSERT_NE(tell(strength * earth()), Verdict::Fits) << i;
  }
  EXPECT_EQ(gate_.adoptions(), 0U);
}

TEST_F(FieldGateTest, what_was_adopted_stands_beside_the_reference) {
  learn();
  for (int i = 0; i < 600; ++i) (void)tell(1.5 * earth());
  EXPECT_EQ(gate_.adoptions(), 1U);
  EXPECT_EQ(tell(1.5 * earth()), Verdict::Fits);
  EXPECT_EQ(tell(earth()), Verdict::Fits);
}

// --- figures of docs/ekf.md, "Better than its inputs" ---

// A robot that turns on a plane, 100 readings a second; iron bends its field. RMS of the heading's error in degrees, of 11 seeds.
struct Turning {
  std::function<Eigen::Vector3d(double t_s)> iron = [](double) { return Eigen::Vector3d{0, 0, 0}; };  // in the world, T
  double gyro_bias_rps = 0.002;
};

double heading_rms_deg(const Turning& how, const FieldGateOptions& options, bool madgwick) {
  double squares = 0.0;
  int count = 0;
  for (unsigned seed = 1; seed <= 11; ++seed) {
    std::mt19937 random{seed};
    std::normal_distribution<double> normal;
    const auto noise = [&](double stddev) {
      return Eigen::Vector3d{stddev * normal(random), stddev * normal(random), stddev * normal(random)};
    };
    std::unique_ptr<OrientationFilter> filter;
    if (madgwick) {
      filter = std::make_unique<MadgwickFilter>(WorldFrame::enu(), MadgwickFilter::Settings{});
    } else {
      filter = std::make_unique<ComplementaryFilter>(WorldFrame::enu(), ComplementaryFilter::Settings{});
    }
    FieldGate gate{options};
    double yaw = 0.0;
    bool started = false;
    for (int i = 1; i <= 6000; ++i) {
      const double t_s = 0.01 * i;
      const double rate = 0.4 * std::sin(0.3 * t_s);
      yaw += 0.01 * rate;
      const Eigen::Quaterniond R_SW{Eigen::AngleAxisd{-yaw, kUp}};
      Measurement m{.dt_s = 0.01};
      m.angular_velocity_rps = Eigen::Vector3d{0, 0, rate + how.gyro_bias_rps} + noise(0.002);
      m.acceleration_mps2 = Eigen::Vector3d{0, 0, 9.80665} + noise(0.02);
      const Eigen::Vector3d field = R_SW * (earth() + how.iron(t_s)) + noise(0.3e-6);
      const Eigen::Vector3d up =
          started ? Eigen::Vector3d{filter->orientation().conjugate() * kUp} : m.acceleration_mps2.normalized();
      const bool fits = !options.any() || gate.judge(WallTime{100s + i * 10ms}, field, up) == Verdict::Fits;
      if (fits) m.magnetic_field = field;
      if (!started) {
        started = fits && filter->start(m);
        continue;
      }
      filter->update(m);
      const auto& q = filter->orientation();
      const double heading =
          std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()), 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z()));
      const double error = std::remainder(heading - yaw, 360.0 * kDegree) / kDegree;
      squares += error * error;
      ++count;
    }
  }
  return std::sqrt(squares / count);
}

struct Rms {
  double off, on;
};
Rms compare(const char* what, const Turning& how, const FieldGateOptions& gate, bool madgwick) {
  const Rms rms{heading_rms_deg(how, {}, madgwick), heading_rms_deg(how, gate, madgwick)};
  std::printf("| %-48s | %-13s | %6.2f | %6.2f |\n", what, madgwick ? "Madgwick" : "complementary", rms.off, rms.on);
  return rms;
}

class FieldGateFigures : public ::testing::TestWithParam<bool> {};

TEST_P(FieldGateFigures, iron_that_is_passed_by_no_longer_bends_the_heading) {
  Turning how;
  how.iron = [](double t_s) -> Eigen::Vector3d {
    const double near = std::exp(-std::pow((std::fmod(t_s, 20.0) - 10.0) / 2.0, 2.0));
    return near * Eigen::Vector3d{25e-6, -10e-6, 10e-6};
  };
  const Rms rms = compare("passes iron every 20 s", how, strict(), GetParam());
  EXPECT_LT(rms.on, 0.4 * rms.off);
}

TEST_P(FieldGateFigures, does_no_harm_without_iron_or_with_a_wrong_reference) {
  const Rms clean = compare("no iron", {}, strict(), GetParam());
  EXPECT_LE(clean.on, 1.02 * clean.off + 0.05);
  FieldGateOptions wrong = strict();
  wrong.reference = FieldShape{30e-6, 0.3};
  const Rms silenced = compare("reference wrong (30 uT, 17 deg; there are 48, 65)", {}, wrong, GetParam());
  EXPECT_LE(silenced.on, 1.02 * silenced.off + 0.05);
  Turning parked;
  parked.iron = [](double t_s) -> Eigen::Vector3d {
    return t_s > 20.0 && t_s < 40.0 ? Eigen::Vector3d{10e-6, -5e-6, 5e-6} : Eigen::Vector3d{0, 0, 0};
  };
  const Rms beside = compare("stands beside iron for 20 s", parked, strict(), GetParam());
  EXPECT_LE(beside.on, beside.off);
}
INSTANTIATE_TEST_SUITE_P(Filters, FieldGateFigures, ::testing::Bool());

}  // namespace
}  // namespace nacelle::imu_filter
