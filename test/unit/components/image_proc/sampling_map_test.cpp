// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/sampling_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pictures.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::image_proc {
namespace {

using sensor_msgs::msg::Image;

// One pixel, taken from there.
std::vector<int> sampled(const Image& image, SourcePoint from, Interpolation interpolation) {
  const Picture picture = picture_of(image, plain_encodings()).value();
  SamplingMap map{{image.width, image.height}, {1, 1}};
  map.set(0, 0, from, interpolation);
  std::vector<std::uint8_t> out(static_cast<std::size_t>(picture.encoding.channels));
  map.apply(picture, out.data());
  return {out.begin(), out.end()};
}

TEST(SamplingMap, blends_the_four_neighbours_by_their_distance) {
  const Image image = image_of(
      9, 7, "rgb8", 3, [](double x, double y, int c) { return 10 + 8 * x + 16 * y + 30 * c; }, 3);
  const unsigned seed = 7;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any_x{0, 8}, any_y{0, 6};
  for (int i = 0; i < 200; ++i) {
    const double x = any_x(random), y = any_y(random);
    SCOPED_TRACE(::testing::Message() << "seed " << seed << " at " << x << ' ' << y);
    const auto rgb = sampled(image, {x, y}, Interpolation::Linear);
    for (int c = 0; c < 3; ++c)  // half a step of rounding, and 1/512 pixel in both directions
      ASSERT_NEAR(rgb[static_cast<std::size_t>(c)], 10 + 8 * x + 16 * y + 30 * c, 0.5 + 24.0 / 512);
  }
}

TEST(SamplingMap, takes_the_nearest_pixel_without_a_blend) {
  const Image image = image_of(3, 2, "mono8", 1, [](double x, double y, int) { return 100 * y + 10 * x; });
  EXPECT_EQ(sampled(image, {1.4, 0.4}, Interpolation::Nearest), std::vector<int>{10});
  EXPECT_EQ(sampled(image, {1.6, 0.6}, Interpolation::Nearest), std::vector<int>{120});
}

TEST(SamplingMap, reaches_the_outermost_pixels_and_is_black_beyond) {
  for (const auto& [width, height] : {std::pair{1U, 1U}, {1U, 4U}, {4U, 1U}, {4U, 4U}}) {
    // Of the exact size: a sanitizer sees the first byte too many.
    const Image image = image_of(width, height, "bgra8", 4, [](double, double, int c) { return 50 + c; });
    const double x = width - 1, y = height - 1;
    SCOPED_TRACE(::testing::Message() << width << ' ' << height);
    const std::vector<int> inside{50, 51, 52, 53}, outside{0, 0, 0, 0};
    EXPECT_EQ(sampled(image, {x, y}, Interpolation::Linear), inside);
    EXPECT_EQ(sampled(image, {0, 0}, Interpolation::Linear), inside);
    EXPECT_EQ(sampled(image, {x + 0.01, y}, Interpolation::Linear), outside);
    EXPECT_EQ(sampled(image, {x, y + 0.01}, Interpolation::Linear), outside);
    EXPECT_EQ(sampled(image, {-0.01, 0}, Interpolation::Linear), outside);
    EXPECT_EQ(sampled(image, {0, -0.01}, Interpolation::Linear), outside);
    EXPECT_EQ(sampled(image, {1e300, 0}, Interpolation::Linear), outside);
    EXPECT_EQ(sampled(image, {std::nan(""), 0}, Interpolation::Linear), outside);
    EXPECT_EQ(sampled(image, {0, std::nan("")}, Interpolation::Nearest), outside);
    EXPECT_EQ(sampled(image, {INFINITY, -INFINITY}, Interpolation::Nearest), outside);
  }
}

TEST(SamplingMap, takes_nothing_from_the_heap_for_a_picture) {
  const Image image = image_of(64, 48, "rgb8", 3, [](double x, double, int) { return x; });
  SamplingMap map{{64, 48}, {64, 48}};
  Image made;
  set_shape(made, 64, 48, picture_of(image, plain_encodings())->encoding);
  const test::AllocationGuard guard;
  for (int i = 0; i < 10; ++i) {
    const auto picture = picture_of(image, plain_encodings());
    set_shape(made, 64, 48, picture->encoding);
    map.apply(*picture, made.data.data());
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace nacelle::image_proc
