// SPDX-License-Identifier: Apache-2.0
#include "camera/port/pattern_source.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "camera/port/camera_fault.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::camera {
namespace {

std::vector<std::uint8_t> picture(const PatternScene& scene, std::uint64_t frame) {
  std::vector<std::uint8_t> bytes(scene.frame_bytes());
  scene.render(frame, bytes);
  return bytes;
}

bool is_disc(const std::uint8_t* rgb) { return rgb[0] == 255 && rgb[1] == 120 && rgb[2] == 0; }

TEST(PatternScene, shows_the_disc_where_and_as_large_as_it_says) {
  const PatternScene scene{640, 480, kRgb24};
  for (std::uint64_t frame = 0; frame < 3000; frame += 37) {
    const auto bytes = picture(scene, frame);
    double area = 0, sum_u = 0, sum_v = 0;
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        if (!is_disc(&bytes[(static_cast<std::size_t>(y) * 640 + static_cast<std::size_t>(x)) * 3])) continue;
        area += 1;
        sum_u += x;
        sum_v += y;
      }
    }
    const DiscPosition disc = PatternScene::disc_position(frame);
    const Pinhole lens = scene.pinhole();
    const double radius_px = 0.5 * lens.focal_px * PatternScene::kDiscDiameter_m / disc.z_m;
    ASSERT_NEAR(std::sqrt(area / M_PI), radius_px, 0.15) << "frame " << frame;
    ASSERT_NEAR(sum_u / area, lens.centre_u_px + lens.focal_px * disc.x_m / disc.z_m, 0.15) << "frame " << frame;
    ASSERT_NEAR(sum_v / area, lens.centre_v_px + lens.focal_px * disc.y_m / disc.z_m, 0.15) << "frame " << frame;
  }
}

TEST(PatternScene, is_a_function_of_the_frame_number_alone) {
  for (const FourCc format : {kRgb24, kBgr24, kYuyv, kUyvy, kGrey}) {
    const PatternScene scene{320, 240, format}, other{320, 240, format};
    std::vector<std::uint8_t> dirty(scene.frame_bytes(), 0xCD);
    other.render(7, dirty);
    other.render(90, dirty);
    EXPECT_EQ(dirty, picture(scene, 90)) << to_text(format);
    EXPECT_NE(dirty, picture(scene, 91)) << to_text(format);
  }
}

TEST(PatternScene, writes_nothing_beyond_its_frame_in_any_size) {
  for (const FourCc format : {kRgb24, kYuyv, kUyvy, kGrey}) {
    for (const auto& [width, height] : {std::pair{16U, 16U}, {16U, 200U}, {200U, 16U}, {642U, 361U}}) {
      const PatternScene scene{width, height, format};
      std::vector<std::uint8_t> bytes(scene.frame_bytes() + 64, 0xEE);
      for (std::uint64_t frame = 0; frame < 300; frame += 11) scene.render(frame, bytes);
      for (std::size_t i = scene.frame_bytes(); i < bytes.size(); ++i) ASSERT_EQ(bytes[i], 0xEE);
    }
  }
}

struct PatternSourceTest : ::testing::Test {
  void begin() {
    CaptureWish wish;
    wish.pixel_format = kGrey;
    const auto format = source.open(wish);
    ASSERT_TRUE(format);
    ASSERT_TRUE(format.value().fills_offered_memory);
    memory.resize(format.value().frame_bytes);
    ASSERT_TRUE(source.start());
  }
  Result<Frame, CaptureFault> next() { return source.next(clock.now(), memory); }

  test::ManualClock clock;
  PatternSource source{clock};
  std::vector<std::uint8_t> memory;
};

TEST_F(PatternSourceTest, keeps_its_rate_whatever_the_caller_s_delays) {
  begin();
  const WallTime start = clock.wall_now();
  for (int frame = 0; frame < 300; ++frame) {
    const auto drawn = next();
    ASSERT_TRUE(drawn) << frame;
    EXPECT_EQ(drawn.value().sequence, static_cast<std::uint64_t>(frame));
    EXPECT_EQ(drawn.value().captured - start, Duration{33333333} * frame);
    EXPECT_EQ(drawn.value().bytes.data(), memory.data());
    ASSERT_FALSE(next());
    // Late by something each time, never by a period.
    clock.advance(Duration{33333333} * (frame + 1) - (clock.wall_now() - start) + 1ms * (frame % 20));
  }
  EXPECT_EQ(source.stats().lost, 0U);
}

TEST_F(PatternSourceTest, loses_frames_that_are_not_taken) {
  begin();
  ASSERT_TRUE(next());
  clock.advance(110ms);
  const auto frame = next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame.value().sequence, 3U);
  EXPECT_EQ(frame.value().lost, 2U);
  EXPECT_EQ(source.stats().lost, 2U);
  EXPECT_EQ(source.stats().frames, 2U);
}

TEST_F(PatternSourceTest, an_interrupt_ends_one_wait) {
  begin();
  source.interrupt();
  EXPECT_EQ(next().error(), CaptureFault::NoFrame);
  EXPECT_TRUE(next());
}

TEST_F(PatternSourceTest, refuses_what_it_cannot_draw) {
  CaptureWish wish;
  wish.pixel_format = kMjpeg;
  EXPECT_FALSE(source.open(wish));
  wish = {};
  wish.width = 641;
  EXPECT_FALSE(source.open(wish));
  wish.width = 100000;
  EXPECT_FALSE(source.open(wish));
}

TEST(PatternSource, refuses_what_it_cannot_draw_or_set) {
  const test::ManualClock clock;
  PatternSource source{clock};
  CaptureWish wish;
  wish.pixel_format = kMjpeg;
  const Problem format = source.open(wish).error();
  EXPECT_EQ(format.code, CameraFault::CannotDraw);
  EXPECT_EQ(format.value, "MJPG");
  EXPECT_EQ(format.text(),
            "pattern source: cannot draw pixel format MJPG; use output_encoding rgb8, bgr8, yuyv, uyvy or mono8");

  wish.pixel_format = kRgb24;
  wish.width = 641;
  const Problem size = source.open(wish).error();
  EXPECT_EQ(size.code, CameraFault::CannotDraw);
  EXPECT_EQ(size.value, "[641, 480]");

  Control brightness;
  brightness.name = "brightness";
  const Problem control = source.set_control(brightness, 7).error();
  EXPECT_EQ(control.code, CameraFault::NoControl);
  EXPECT_EQ(control.value, "brightness");
  EXPECT_EQ(control.what, "has no control brightness");
}

}  // namespace
}  // namespace nacelle::camera
