// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/umbmark.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "driven_base.hpp"

namespace nacelle::calibration {
namespace {

constexpr double kSide_m = 4.0;

/// What a base that is believed to be the nominal one shows, without slip.
Umbmark of(const BaseGeometry& real) {
  std::vector<SquareError> errors[2];
  for (const bool is_left : {false, true}) {
    // It drives what its wheels call a square: the wheels turn as those of the nominal base would.
    const BaseGeometry believed = nominal_base();
    WheelPath path{{}};
    const auto roll = [&](double left_m, double right_m) {
      const int steps = 200;
      for (int i = 0; i < steps; ++i) {
        path.push_back({path.back().left_rad + left_m / steps / believed.left_radius_m(),
                        path.back().right_rad + right_m / steps / believed.right_radius_m()});
      }
    };
    const double quarter_m = (is_left ? 1.0 : -1.0) * std::numbers::pi / 2.0 * believed.separation_m() / 2.0;
    for (int i = 0; i < 4; ++i) {
      roll(kSide_m, kSide_m);
      roll(-quarter_m, quarter_m);
    }
    const auto is = end_of(real, path).pose, says = end_of(believed, path).pose;
    errors[is_left ? 1 : 0].push_back({is.x() - says.x(), is.y() - says.y()});
  }
  return umbmark_of(errors[0], errors[1], kSide_m, nominal_base().separation_m());
}

TEST(Umbmark, a_right_base_has_no_errors) {
  const Umbmark found = of(nominal_base());
  EXPECT_NEAR(found.alpha_rad, 0.0, 1e-12);
  EXPECT_NEAR(found.beta_rad, 0.0, 1e-12);
  EXPECT_NEAR(found.separation_ratio, 1.0, 1e-12);
  EXPECT_NEAR(found.radius_ratio, 1.0, 1e-12);
  EXPECT_NEAR(found.worst_m, 0.0, 1e-9);
}

TEST(Umbmark, a_wider_base_turns_less_both_ways) {
  BaseGeometry real = nominal_base();
  real.separation_multiplier = 1.01;
  const Umbmark found = of(real);
  EXPECT_NEAR(found.separation_ratio, 1.01, 5e-4);
  EXPECT_NEAR(found.radius_ratio, 1.0, 1e-4);
  EXPECT_GT(found.alpha_rad, 0.0);
  // 0.9 degrees a corner: 2 L alpha behind and to the outside, both ways.
  EXPECT_NEAR(found.worst_m, std::sqrt(8.0) * kSide_m * found.alpha_rad, 0.02);
}

TEST(Umbmark, a_larger_right_wheel_bends_both_squares_to_the_left) {
  BaseGeometry real = nominal_base();
  real.right_radius_multiplier = 1.0005;
  real.left_radius_multiplier = 0.9995;
  const Umbmark found = of(real);
  EXPECT_NEAR(found.radius_ratio, 1.001, 3e-5);
  EXPECT_NEAR(found.separation_ratio, 1.0, 1e-3);
  EXPECT_GT(found.beta_rad, 0.0);
}

TEST(Umbmark, the_corrected_base_has_the_measured_ratios_and_the_mean_radius_of_before) {
  BaseGeometry real = nominal_base();
  real.separation_multiplier = 0.985;
  real.right_radius_multiplier = 1.001;
  real.left_radius_multiplier = 0.999;
  const BaseGeometry base = corrected(nominal_base(), of(real));
  EXPECT_NEAR(base.separation_multiplier, 0.985, 0.003);
  EXPECT_NEAR(base.right_radius_multiplier / base.left_radius_multiplier, 1.001 / 0.999, 2e-4);
  EXPECT_NEAR(base.left_radius_multiplier + base.right_radius_multiplier, 2.0, 1e-6);
}

}  // namespace
}  // namespace nacelle::calibration
