// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/covariance_parameter.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nacelle::ekf {
namespace {

const StateMatrix kOtherwise = StateMatrix::Identity() * 0.5;

TEST(CovarianceParameter, fifteen_numbers_are_the_diagonal) {
  std::vector<double> numbers(15);
  for (std::size_t i = 0; i < 15; ++i) numbers[i] = 0.1 * static_cast<double>(i + 1);
  const auto read = read_covariance(numbers, kOtherwise);
  ASSERT_TRUE(read);
  EXPECT_DOUBLE_EQ(read->matrix(14, 14), 1.5);
  EXPECT_EQ(read->matrix(0, 1), 0.0);
  EXPECT_TRUE(read->note.empty());
}

TEST(CovarianceParameter, two_hundred_and_twenty_five_numbers_are_everything) {
  std::vector<double> numbers(225, 0.0);
  for (std::size_t i = 0; i < 15; ++i) numbers[i * 16] = 2.0;
  numbers[3 * 15 + 7] = numbers[7 * 15 + 3] = 0.25;
  const auto read = read_covariance(numbers, kOtherwise);
  ASSERT_TRUE(read);
  EXPECT_DOUBLE_EQ(read->matrix(7, 3), 0.25);
  EXPECT_TRUE(read->note.empty());
}

TEST(CovarianceParameter, thirty_six_numbers_are_the_pose_block_and_say_so) {
  std::vector<double> numbers(36, 0.0);
  for (std::size_t i = 0; i < 6; ++i) numbers[i * 7] = 3.0;
  numbers[1] = numbers[6] = 0.5;
  const auto read = read_covariance(numbers, kOtherwise);
  ASSERT_TRUE(read);
  EXPECT_DOUBLE_EQ(read->matrix(5, 5), 3.0);
  EXPECT_DOUBLE_EQ(read->matrix(0, 1), 0.5);
  EXPECT_DOUBLE_EQ(read->matrix(6, 6), 0.5);
  EXPECT_NE(read->note.find("6x6"), std::string::npos);
}

TEST(CovarianceParameter, any_other_count_is_an_error_that_names_the_three) {
  for (const std::size_t count : {0U, 1U, 6U, 14U, 16U, 35U, 37U, 224U, 226U}) {
    const auto read = read_covariance(std::vector<double>(count, 1.0), kOtherwise);
    ASSERT_FALSE(read) << count;
    for (const char* word : {"15", "225", "36"}) EXPECT_NE(read.error().find(word), std::string::npos) << read.error();
    EXPECT_NE(read.error().find(std::to_string(count)), std::string::npos) << read.error();
  }
}

TEST(CovarianceParameter, refuses_what_is_no_covariance) {
  std::vector<double> nan(15, 1.0), negative(15, 1.0), skew(225, 0.0), indefinite(225, 0.0);
  nan[3] = std::nan("");
  negative[4] = -1.0;
  for (std::size_t i = 0; i < 15; ++i) skew[i * 16] = indefinite[i * 16] = 1.0;
  skew[1] = 0.3;
  indefinite[1] = indefinite[15] = 2.0;
  EXPECT_NE(read_covariance(nan, kOtherwise).error().find("3"), std::string::npos);
  EXPECT_NE(read_covariance(negative, kOtherwise).error().find("pitch"), std::string::npos);
  EXPECT_NE(read_covariance(skew, kOtherwise).error().find("symmetric"), std::string::npos);
  EXPECT_NE(read_covariance(indefinite, kOtherwise).error().find("semidefinite"), std::string::npos);
}

TEST(CovarianceParameter, the_defaults_are_accepted_by_their_own_reader) {
  for (const StateMatrix& matrix : {default_process_noise(), default_initial_covariance()}) {
    EXPECT_TRUE(read_covariance(std::vector<double>(matrix.data(), matrix.data() + 225), kOtherwise));
  }
}

}  // namespace
}  // namespace nacelle::ekf
