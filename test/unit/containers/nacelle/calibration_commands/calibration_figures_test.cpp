// SPDX-License-Identifier: Apache-2.0
// The figures of docs/ekf.md, section "Calibration by driving", and with NACELLE_PICTURES=FOLDER its pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

#include "calibration_commands/model/base_estimate.hpp"
#include "calibration_commands/model/lever_fit.hpp"
#include "drawing/chart.hpp"
#include "driven_base.hpp"
#include "driven_imu.hpp"
#include "nacelle/base/files.hpp"

namespace nacelle::calibration {
namespace {

void write_picture(const std::string& name, const drawing::Chart& chart) {
  const char* const folder = std::getenv("NACELLE_PICTURES");
  if (folder == nullptr) return;
  ASSERT_TRUE(write_whole_file(std::string{folder} + "/" + name, drawing::chart_svg(chart)));
}

/// Fewer where nobody looks at the figures.
int seeds() { return std::getenv("NACELLE_PICTURES") != nullptr ? 44 : 11; }

/// Errors of seeds, with the band in which 95 % of them should be.
struct Errors {
  drawing::Chart chart;

  Errors(const std::string& unit, const std::string& name) {
    chart.x_label = "seed";
    chart.y_label = unit;
    chart.lines = {{name, {}}, {"95 % band", {}}, {"95 % band, below", {}}};
  }
  void add(std::uint64_t seed, double error, double stddev) {
    const auto x = static_cast<double>(seed);
    chart.lines[0].points.push_back({x, error});
    chart.lines[1].points.push_back({x, 1.96 * stddev});
    chart.lines[2].points.push_back({x, -1.96 * stddev});
  }
};

/// Where a base goes that drives what its wheels call a square.
drawing::ChartLine track_of(const std::string& name, const BaseGeometry& real, bool is_left) {
  const BaseGeometry believed = nominal_base();
  constexpr double kSide_m = 1.0;
  WheelPath path{{}};
  drawing::ChartLine line{name, {{0.0, 0.0}}};
  const auto roll = [&](double left_m, double right_m) {
    constexpr int kSteps = 40;
    for (int i = 0; i < kSteps; ++i) {
      path.push_back({path.back().left_rad + left_m / kSteps / believed.left_radius_m(),
                      path.back().right_rad + right_m / kSteps / believed.right_radius_m()});
      const auto end = end_of(real, path).pose;
      line.points.push_back({end.x(), end.y()});
    }
  };
  const double quarter_m = (is_left ? 1.0 : -1.0) * std::numbers::pi / 2.0 * believed.separation_m() / 2.0;
  for (int i = 0; i < 4; ++i) {
    roll(kSide_m, kSide_m);
    roll(-quarter_m, quarter_m);
  }
  return line;
}

TEST(CalibrationFigures, tracks_of_squares_by_wheels_that_are_wrong) {
  drawing::Chart chart;
  chart.x_label = "x in m";
  chart.y_label = "y in m";
  chart.equal_scales = true;
  chart.lines = {track_of("as its wheels say", nominal_base(), false),
                 track_of("really, clockwise", real_base(), false),
                 track_of("really, counter-clockwise", real_base(), true)};
  const auto believed = chart.lines[0].points.back(), really = chart.lines[1].points.back();
  EXPECT_NEAR(std::hypot(believed.x, believed.y), 0.0, 1e-9);
  EXPECT_GT(std::hypot(really.x, really.y), 0.05);
  write_picture("umbmark_tracks.svg", chart);
}

TEST(CalibrationFigures, wheels_over_many_seeds) {
  struct Case {
    const char* name;
    SlipNoise slip;
    int squares;
    double side_m;
    bool is_by_hand;
    double most_rms;  // relative
  };
  const Case cases[] = {{"by hand, 5 squares of 1 m", kLittleSlip, 5, 1.0, true, 0.003},
                        {"by hand, 5 squares of 2 m", kLittleSlip, 5, 2.0, true, 0.003},
                        {"by hand, 5 squares of 2 m, much slip", kMuchSlip, 5, 2.0, true, 0.004},
                        {"by topic, 1 square of 0.5 m", kLittleSlip, 1, 0.5, false, 0.003},
                        {"by topic, 3 squares of 1 m", kLittleSlip, 3, 1.0, false, 0.0015},
                        {"by topic, 3 squares of 1 m, much slip", kMuchSlip, 3, 1.0, false, 0.002}};
  std::printf("%-40s %-24s %-24s within 0.5 %%\n", "RMS, worst in %", "radii", "separation");
  for (const auto& c : cases) {
    double radius_squares = 0.0, separation_squares = 0.0, radius_worst = 0.0, separation_worst = 0.0;
    int within = 0;
    Errors errors{"error of the separation in %", "error"};
    for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(seeds()); ++seed) {
      const auto ways =
          c.is_by_hand ? by_hand(seed, c.slip, c.squares, c.side_m) : by_topic(seed, c.slip, c.squares, c.side_m);
      const MeasurementNoise noise = c.is_by_hand ? MeasurementNoise{0.003, 0.01} : MeasurementNoise{0.001, 0.001};
      const auto found = estimate_base(nominal_base(), nominal_base(), ways, noise);
      ASSERT_TRUE(found) << c.name << ", seed " << seed;
      const BaseGeometry real = real_base();
      const double left = found->base.left_radius_multiplier / real.left_radius_multiplier - 1.0;
      const double right = found->base.right_radius_multiplier / real.right_radius_multiplier - 1.0;
      const double separation = found->base.separation_multiplier / real.separation_multiplier - 1.0;
      errors.add(seed, 100 * separation, 100 * found->separation_stddev);
      radius_squares += (left * left + right * right) / (2.0 * seeds());
      separation_squares += separation * separation / seeds();
      radius_worst = std::max({radius_worst, std::abs(left), std::abs(right)});
      separation_worst = std::max(separation_worst, std::abs(separation));
      within += std::max({std::abs(left), std::abs(right), std::abs(separation)}) <= 0.005 ? 1 : 0;
    }
    std::printf("%-40s %.3f, %-17.3f %.3f, %-17.3f %d of %d\n", c.name, 100 * std::sqrt(radius_squares),
                100 * radius_worst, 100 * std::sqrt(separation_squares), 100 * separation_worst, within, seeds());
    if (!c.is_by_hand && c.side_m < 1.0) write_picture("umbmark_errors.svg", errors.chart);
    EXPECT_LT(std::sqrt(std::max(radius_squares, separation_squares)), c.most_rms) << c.name;
  }
}

TEST(CalibrationFigures, imu_over_many_seeds) {
  struct Case {
    int eights;
    double rate_rps, radius_m;
  };
  std::printf("%-28s %-16s %-16s sure\n", "RMS, worst", "yaw in degrees", "lever arm in mm");
  for (const auto& [eights, rate_rps, radius_m] : {Case{1, 1.5, 0.3}, {2, 1.0, 0.4}, {2, 1.5, 0.3}, {4, 1.5, 0.3}}) {
    double yaw_squares = 0.0, lever_squares = 0.0, yaw_worst = 0.0, lever_worst = 0.0;
    Errors errors{"error of the mounting yaw in degrees", "error"};
    int found = 0;  // that are sure enough for the command
    for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(seeds()); ++seed) {
      const Drive drive{.yaw_rad = 0.1,
                        .x_m = 0.12,
                        .y_m = -0.05,
                        .radius_m = radius_m,
                        .rate_rps = rate_rps,
                        .circles = 2 * eights,
                        .seed = seed};
      const Series series = driven(drive);
      const auto fit = fit_lever(series.readings, series.wheels);
      ASSERT_TRUE(fit) << "seed " << seed;
      found += fit->is_sure() ? 1 : 0;
      const double yaw = (fit->yaw_rad - drive.yaw_rad) / kDegree_rad;
      const double lever = 1e3 * std::hypot(fit->x_m - drive.x_m, fit->y_m - drive.y_m);
      errors.add(seed, yaw, fit->yaw_stddev_rad / kDegree_rad);
      yaw_squares += yaw * yaw;
      lever_squares += lever * lever;
      yaw_worst = std::max(yaw_worst, std::abs(yaw));
      lever_worst = std::max(lever_worst, lever);
    }
    std::printf("%d eights, %.1f rad/s, %.1f m    %.3f, %-9.3f %.2f, %-10.2f %d\n", eights, rate_rps, radius_m,
                std::sqrt(yaw_squares / seeds()), yaw_worst, std::sqrt(lever_squares / seeds()), lever_worst, found);
    if (eights == 2 && rate_rps > 1.2) write_picture("imu_yaw_errors.svg", errors.chart);
    EXPECT_LT(yaw_worst, 0.5);
    EXPECT_LT(lever_worst, 10.0);
    if (eights > 1) { EXPECT_EQ(found, seeds()); }
  }
}

}  // namespace
}  // namespace nacelle::calibration
