// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "parity_run.hpp"
#include "support/places.hpp"

namespace nacelle::ekf::parity {
namespace {

struct Row {
  std::string family;
  unsigned seed{};
  std::array<double, 46> numbers{};
};
std::vector<Row> rows_of_robot_localization(const std::string& name) {
  std::vector<Row> rows;
  std::ifstream file{test::data("ekf_parity/" + name)};
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields{line};
    Row row;
    fields >> row.family >> row.seed;
    for (double& number : row.numbers) fields >> number;
    EXPECT_TRUE(static_cast<bool>(fields)) << line.substr(0, 40);
    rows.push_back(row);
  }
  return rows;
}

/// The largest difference of two end states: absolute, or relative where a number is larger than 1.
double difference(const std::array<double, 46>& a, const std::array<double, 46>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double gap = std::abs(a[i] - b[i]) / std::max(1.0, std::abs(b[i]));
    most = std::isnan(gap) ? 1e9 : std::max(most, gap);
  }
  return most;
}

TEST(Parity, ends_where_robot_localization_does) {
  const auto rows = rows_of_robot_localization("end_states.tsv");
  ASSERT_EQ(rows.size(), kFamilies.size() * kStreamsPerFamily);
  std::map<std::string, std::pair<double, double>> most;
  for (const Row& row : rows) {
    const Stream stream = make_stream(row.family, row.seed);
    auto& [with, without] = most[row.family];
    const double same = difference(run(stream, {.robot_localization_rotations = true}), row.numbers);
    with = std::max(with, same);
    without = std::max(without, difference(run(stream, {.robot_localization_rotations = false}), row.numbers));
    EXPECT_LT(same, 1e-6) << row.family << " " << row.seed;
  }
  for (const auto& [family, m] : most)
    std::printf("%-16s %.1e   as rotations %.1e\n", family.c_str(), m.first, m.second);
}

// robot_localization's own recordings are not in this tree (see the data's README): a folder with them is named by NACELLE_EKF_RECORDINGS.
TEST(Parity, recordings_of_robot_localization_end_where_it_does) {
  const char* const folder = std::getenv("NACELLE_EKF_RECORDINGS");
  if (folder == nullptr) GTEST_SKIP() << "NACELLE_EKF_RECORDINGS is not set";
  const auto rows = rows_of_robot_localization("recordings.tsv");
  ASSERT_EQ(rows.size(), 2U);
  for (const Row& row : rows) {
    std::ifstream lines{std::string{folder} + "/bag" + std::to_string(row.seed) + ".txt"};
    const Stream stream = read_recording(lines, row.seed);
    ASSERT_GT(stream.messages.size(), 1000U) << row.seed;
    const auto ours = run(stream, {.robot_localization_rotations = true});
    const auto as_rotations = run(stream, {.robot_localization_rotations = false});
    std::printf("recording %u: difference %.1e; end %.4f %.4f %.4f, as rotations %.4f %.4f %.4f\n", row.seed,
                difference(ours, row.numbers), ours[1], ours[2], ours[3], as_rotations[1], as_rotations[2],
                as_rotations[3]);
    EXPECT_LT(difference(ours, row.numbers), 1e-6) << row.seed;
  }
}

}  // namespace
}  // namespace nacelle::ekf::parity
