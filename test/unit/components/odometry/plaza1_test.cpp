// SPDX-License-Identifier: Apache-2.0
// A recorded drive of 1.9 km (test/data/plaza1): an integrator without free parameters has one answer to it.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "odometry/model/wheel_odometry.hpp"
#include "support/places.hpp"

namespace nacelle::odometry {
namespace {

std::vector<std::vector<double>> rows_of(const std::string& file) {
  std::ifstream in{test::data("plaza1/" + file)};
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(in, line);  // the names of the columns
  while (std::getline(in, line)) {
    std::vector<double> row;
    for (std::size_t at = 0; at < line.size();) {
      std::size_t used = 0;
      row.push_back(std::stod(line.substr(at), &used));
      at += used + 1;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

TEST(Plaza1, the_arc_ends_where_the_reference_integration_ends) {
  const auto steps = rows_of("odometry.csv");
  const auto start_and_end = rows_of("truth_ends.csv");
  ASSERT_EQ(steps.size(), 9657U);
  ASSERT_EQ(start_and_end.size(), 2U);
  double x = start_and_end[0][1], y = start_and_end[0][2], yaw = start_and_end[0][3];
  const double separation_m = 1.0;  // any: only distance and turn enter
  for (const auto& step : steps) {
    const double half = 0.5 * step[2] * separation_m;
    const Moved to = move(x, y, yaw, {step[1] - half, step[1] + half}, separation_m);
    x = to.x_m;
    y = to.y_m;
    yaw = to.yaw_rad;
  }
  const double end_error = std::hypot(x - start_and_end[1][1], y - start_and_end[1][2]);
  // The set's own figure for translating at the middle heading (case A) is 4.449 m; the exact arc is longer than its chord, by less
  // than 3 mm in all.
  EXPECT_NEAR(end_error, 4.449, 0.005);
  EXPECT_NEAR(std::remainder(yaw - start_and_end[1][3], 2 * M_PI), 0.0, 1e-3) << "the turns are those of the truth";
}

}  // namespace
}  // namespace nacelle::odometry
