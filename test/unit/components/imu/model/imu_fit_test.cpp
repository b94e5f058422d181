// SPDX-License-Identifier: Apache-2.0
#include "imu/model/imu_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace nacelle::imu {
namespace {

constexpr double kG = 9.80665;
constexpr double kDeg = std::numbers::pi / 180.0;

Vector3 corrected(const VectorFit& fit, const Vector3& v) {
  Vector3 c{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t i = 0; i < 3; ++i) c[r] += fit.matrix[3 * r + i] * (v[i] - fit.bias[i]);
  }
  return c;
}
double length(const Vector3& v) { return std::hypot(v[0], v[1], v[2]); }

/// Six sides, each some degrees off, as people put things down, read with bias and scale errors.
std::vector<Vector3> six_positions(std::mt19937& random) {
  std::normal_distribution<double> tilt{0.0, 5 * kDeg}, noise{0.0, 0.002};
  std::vector<Vector3> all;
  for (int side = 0; side < 6; ++side) {
    Eigen::Vector3d up = Eigen::Vector3d::Zero();
    up[side / 2] = side % 2 == 0 ? 1.0 : -1.0;
    up += Eigen::Vector3d{tilt(random), tilt(random), tilt(random)};
    up.normalize();
    all.push_back({kG * up.x() * 1.02 + 0.3 + noise(random), kG * up.y() * 0.97 - 0.2 + noise(random),
                   kG * up.z() * 1.03 + 0.4 + noise(random)});
  }
  return all;
}

TEST(FitAcceleration, finds_bias_and_scale_from_six_positions_that_are_not_exact) {
  std::mt19937 random{6};
  const auto fit = fit_acceleration(six_positions(random), kG);
  ASSERT_TRUE(fit);
  const Vector3 bias{0.3, -0.2, 0.4}, scale{1 / 1.02, 1 / 0.97, 1 / 1.03};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(fit->bias[i], bias[i], 0.01);
    EXPECT_NEAR(fit->matrix[4 * i], scale[i], 0.001);
  }
  EXPECT_LT(fit->rms_error, 1e-6);  // six unknowns, six equations
}

TEST(FitAcceleration, five_sides_or_one_side_twice_are_no_calibration) {
  std::mt19937 random{7};
  auto positions = six_positions(random);
  const Vector3 first = positions.front();
  positions.pop_back();
  EXPECT_EQ(fit_acceleration(positions, kG).error(), FitFault::TooFew);
  positions.push_back(first);
  EXPECT_EQ(fit_acceleration(positions, kG).error(), FitFault::NotCovered);
}

TEST(FitAcceleration, readings_in_g_are_absurd) {
  std::mt19937 random{8};
  auto positions = six_positions(random);
  for (auto& p : positions) {
    for (double& axis : p) axis *= 2.0;
  }
  EXPECT_EQ(fit_acceleration(positions, kG).error(), FitFault::Absurd);
}

/// A field of 48 uT seen through hard and soft iron while the sensor turns: in all directions, or about z only.
std::vector<Vector3> turned(std::mt19937& random, bool about_z_only, int count) {
  Eigen::Matrix3d soft;
  soft << 1.1, 0.05, 0.02, 0.05, 0.95, -0.04, 0.02, -0.04, 1.0;
  const Eigen::Vector3d hard{30e-6, -12e-6, 55e-6};
  std::normal_distribution<double> draw{0.0, 1.0}, noise{0.0, 0.3e-6};
  std::vector<Vector3> all;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d field{20e-6 * std::cos(0.1 * i), 20e-6 * std::sin(0.1 * i), -43e-6};
    if (!about_z_only) field = 48e-6 * Eigen::Vector3d{draw(random), draw(random), draw(random)}.normalized();
    const Eigen::Vector3d seen = soft * field + hard;
    all.push_back({seen.x() + noise(random), seen.y() + noise(random), seen.z() + noise(random)});
  }
  return all;
}

TEST(FitField, undoes_hard_and_soft_iron) {
  const unsigned seed = 9;
  std::mt19937 random{seed};
  const auto readings = turned(random, false, 500);
  const auto fit = fit_field(readings);
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->is_flat);
  EXPECT_NEAR(fit->bias[0], 30e-6, 0.2e-6);
  EXPECT_NEAR(fit->bias[1], -12e-6, 0.2e-6);
  EXPECT_NEAR(fit->bias[2], 55e-6, 0.2e-6);
  EXPECT_NEAR(fit->length, 48e-6, 1e-6);
  for (const auto& v : readings) EXPECT_NEAR(length(corrected(*fit, v)), fit->length, 1.5e-6) << "seed " << seed;
  EXPECT_LT(fit->rms_error, 0.5e-6);
}

TEST(FitField, of_a_robot_that_turns_on_the_spot_the_plane_is_fitted) {
  std::mt19937 random{10};
  const auto readings = turned(random, true, 400);
  const auto fit = fit_field(readings);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->is_flat);
  EXPECT_EQ(fit->bias[2], 0.0);
  EXPECT_EQ(fit->matrix[8], 1.0);
  for (const auto& v : readings) {
    const Vector3 c = corrected(*fit, v);
    EXPECT_NEAR(std::hypot(c[0], c[1]), fit->length, 1.5e-6);
  }
}

TEST(FitField, a_part_of_a_turn_is_no_calibration) {
  std::mt19937 random{11};
  auto readings = turned(random, true, 400);
  std::vector<Vector3> part;
  for (std::size_t i = 0; i < 30; ++i) part.push_back(readings[i]);  // 170 degrees
  EXPECT_FALSE(fit_field(part));
}

TEST(FitField, noise_is_no_ellipsoid) {
  std::mt19937 random{12};
  std::uniform_real_distribution<double> draw{-50e-6, 50e-6};
  std::vector<Vector3> readings;
  for (int i = 0; i < 500; ++i) readings.push_back({draw(random), draw(random), draw(random)});
  EXPECT_EQ(fit_field(readings).error(), FitFault::NoEllipsoid);
}

TEST(Composed, gives_the_correction_that_does_what_both_do) {
  const AffineCorrection now{{0.1, -0.2, 0.3}, {1.1, 0.02, 0, 0.02, 0.9, 0, 0, 0, 1.05}};
  const Vector3 mounting{0.1, -0.2, 1.3};
  VectorFit fit;
  fit.bias = {0.5, 0.4, -0.1};
  fit.matrix = {0.98, 0.01, 0, 0.01, 1.02, 0.03, 0, 0.03, 1.0};
  const Vector3 reading{3.0, -4.0, 8.0};
  const auto published = [&](const AffineCorrection& c) {
    SampleCorrection correction;
    correction.acceleration_bias_mps2 = c.bias;
    correction.acceleration_matrix = c.matrix;
    correction.mounting_rpy_rad = mounting;
    Sample sample;
    sample.acceleration_mps2 = reading;
    SampleCorrector{correction}.apply(sample);
    return sample.acceleration_mps2;
  };
  const Vector3 expected = corrected(fit, published(now));
  const Vector3 seen = published(composed(now, mounting, fit));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(seen[i], expected[i], 1e-12);
}

}  // namespace
}  // namespace nacelle::imu
