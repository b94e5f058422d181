// SPDX-License-Identifier: Apache-2.0
#include "transforms/model/static_transform.hpp"

#include <gtest/gtest.h>

namespace nacelle::transforms {
namespace {

TEST(ReadStaticTransform, takes_yaw_pitch_roll_in_static_transform_publishers_order) {
  const auto read = read_static_transform("1 -2.5 +0.3 0.1 0.2 0.3 base_link laser");
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(read->parent, "base_link");
  EXPECT_EQ(read->child, "laser");
  EXPECT_EQ(read->X_PC.translation_m, (Eigen::Vector3d{1, -2.5, 0.3}));
  const auto angles = spatial::rpy_from_quaternion(read->X_PC.rotation);
  EXPECT_NEAR(angles.yaw_rad, 0.1, 1e-12);
  EXPECT_NEAR(angles.pitch_rad, 0.2, 1e-12);
  EXPECT_NEAR(angles.roll_rad, 0.3, 1e-12);
}

TEST(ReadStaticTransform, takes_a_quaternion_with_w_last) {
  const auto read = read_static_transform("0 0 0  0 0 1 0  /map\t/odom");
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(read->parent, "map");
  EXPECT_NEAR(std::abs(spatial::yaw_from_quaternion(read->X_PC.rotation)), spatial::kPi, 1e-12);
}

TEST(ReadStaticTransform, says_what_is_wrong) {
  const auto reason = [](const char* text) {
    const auto read = read_static_transform(text);
    return read ? std::string{"accepted"} : read.error();
  };
  EXPECT_NE(reason("").find("0 words"), std::string::npos);
  EXPECT_NE(reason("1 2 3 a b").find("5 words"), std::string::npos);
  EXPECT_NE(reason("1 2 x 0 0 0 a b").find("'x' (word 3)"), std::string::npos);
  EXPECT_NE(reason("1 2 3 0 0 nan a b").find("'nan'"), std::string::npos);
  EXPECT_NE(reason("1 2 1e999 0 0 0 a b").find("1e999"), std::string::npos);
  EXPECT_NE(reason("1 2 3 0 0 0 a a").find("same frame"), std::string::npos);
  EXPECT_NE(reason("1 2 3 0 0 0 a /").find("no name"), std::string::npos);
  EXPECT_NE(reason("1 2 3 1 1 0 0 a b").find("length"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::transforms
