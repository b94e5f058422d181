// SPDX-License-Identifier: Apache-2.0
// What the port on libcamera computes, without libcamera.
#include <gtest/gtest.h>

#include "camera/model/drm_format.hpp"
#include "camera/model/sensor_time.hpp"

namespace nacelle::camera {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(DrmFormat, has_other_names_for_colours_by_byte_and_for_grey_only) {
  EXPECT_EQ(drm_of(kBgr24), 0x34324752U) << "DRM_FORMAT_RGB888";
  EXPECT_EQ(drm_of(kRgb24), 0x34324742U) << "DRM_FORMAT_BGR888";
  EXPECT_EQ(drm_of(kGrey), 0x20203852U) << "DRM_FORMAT_R8";
  EXPECT_EQ(drm_of(kNv12), kNv12);
  for (const auto* format = readable_formats_begin(); format != readable_formats_end(); ++format)
    EXPECT_EQ(v4l2_of(drm_of(format->code)), format->code) << to_text(format->code);
}

TEST(DrmFormat, knows_mosaics) {
  EXPECT_TRUE(is_bayer(fourcc("BA81")));
  EXPECT_TRUE(is_bayer(fourcc("RGGB")));
  EXPECT_FALSE(is_bayer(kNv12));
}

TEST(SensorTime, is_of_either_clock) {
  EXPECT_EQ(age_of(100 * kSecond, 100 * kSecond + 30'000'000, 0), Duration{30ms});
  // Suspended for an hour: a stamp of the clock that goes on is an hour ahead of the other.
  const std::int64_t suspended = 3600 * kSecond;
  EXPECT_EQ(age_of(100 * kSecond + suspended, 100 * kSecond + 30'000'000, suspended), Duration{30ms});
  EXPECT_EQ(age_of(100 * kSecond, 100 * kSecond + 30'000'000, suspended), Duration{30ms});
}

TEST(SensorTime, makes_no_sense_in_the_future_or_after_ten_seconds) {
  EXPECT_EQ(age_of(0, 100 * kSecond, 0), std::nullopt);
  EXPECT_EQ(age_of(100 * kSecond + 2'000'000, 100 * kSecond, 0), std::nullopt);
  EXPECT_EQ(age_of(100 * kSecond + 500'000, 100 * kSecond, 0), Duration{-500us})
      << "the two clocks are read one after the other";
  EXPECT_EQ(age_of(100 * kSecond - 10 * kSecond, 100 * kSecond, 0), Duration{10s});
  EXPECT_EQ(age_of(90 * kSecond - 1, 100 * kSecond, 0), std::nullopt);
}

}  // namespace
}  // namespace nacelle::camera
