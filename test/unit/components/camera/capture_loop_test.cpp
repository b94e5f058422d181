// SPDX-License-Identifier: Apache-2.0
#include "camera/component/capture_loop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "camera/port/camera_fault.hpp"
#include "camera/port/pattern_source.hpp"
#include "camera/port/v4l2_capture.hpp"
#include "jpeg_picture.hpp"
#include "pooled_writer.hpp"
#include "scripted_camera.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::camera {
namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::CompressedImage;
using sensor_msgs::msg::Image;
using Turn = CaptureLoop::Turn;

struct CaptureLoopTest : ::testing::Test {
  CaptureLoop make(CapturePort& port, const char* encoding, FourCc format = kYuyv) {
    CaptureLoop::Settings settings;
    settings.wish.pixel_format = format;
    settings.output = find_pixel_format(std::string_view{encoding});
    settings.frame_id = "camera_optical_frame";
    return CaptureLoop{{port, clock, logger, images.publisher, infos.publisher, [this] { ++reopened; }}, settings};
  }
  Turn turn(CaptureLoop& loop) { return loop.turn(clock.now() + 100ms); }

  test::ManualClock clock;
  Logger logger{"camera"};
  PooledTopic<Image> images{8};
  PooledTopic<CameraInfo> infos{8};
  std::shared_ptr<ScriptedCamera> camera = std::make_shared<ScriptedCamera>(clock);
  V4l2Capture capture{clock, camera};
  int reopened = 0;
  std::uint32_t sequence = 0;
};

TEST_F(CaptureLoopTest, the_reader_sees_the_drivers_buffer_when_encodings_are_equal) {
  auto loop = make(capture, "yuyv");
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  ASSERT_TRUE(camera->deliver(0, 0x42));
  int seen = 0;
  images.writer->on_message = [&](const Image& image) {
    ++seen;
    EXPECT_EQ(image.data.data(), camera->buffers[0].memory.data());
    EXPECT_EQ(image.data.size(), 614400U);
    EXPECT_EQ(image.encoding, "yuyv");
    EXPECT_EQ(image.step, 1280U);
    EXPECT_EQ(image.width, 640U);
    EXPECT_EQ(image.height, 480U);
    EXPECT_EQ(image.header.frame_id, "camera_optical_frame");
    EXPECT_FALSE(camera->buffers[0].queued);
  };

  EXPECT_EQ(turn(loop), Turn::Frame);

  EXPECT_EQ(seen, 1);
  EXPECT_TRUE(camera->buffers[0].queued) << "the last reader gave the buffer back to the driver";
  EXPECT_EQ(loop.stats().adopted, 1U);
}

TEST_F(CaptureLoopTest, copies_rather_than_starving_the_device) {
  auto loop = make(capture, "yuyv");
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(camera->deliver(sequence++, 1)) << "frame " << i << " found no buffer";
    images.writer->keep_next = i < 5;  // a reader that holds five images
    ASSERT_EQ(turn(loop), Turn::Frame);
    const auto queued =
        std::count_if(camera->buffers.begin(), camera->buffers.end(), [](const auto& b) { return b.queued; });
    EXPECT_GE(queued, std::ptrdiff_t{kAlwaysQueued} + 1) << "after frame " << i;
  }
  EXPECT_EQ(loop.stats().published, 12U);
  EXPECT_EQ(loop.stats().adopted, 3U);
  EXPECT_EQ(loop.stats().copied, 9U);

  for (Block* block : images.writer->kept) drop_reference(*block);
  images.writer->kept.clear();
  ASSERT_TRUE(camera->deliver(sequence++, 1));
  ASSERT_EQ(turn(loop), Turn::Frame);
  EXPECT_EQ(loop.stats().adopted, 4U);
}

TEST_F(CaptureLoopTest, image_and_camera_info_have_one_stamp_that_of_the_capture) {
  auto loop = make(capture, "rgb8");
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  ASSERT_TRUE(camera->deliver(0, 1, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, -1, 30ms));
  Image image;
  CameraInfo info;
  images.writer->on_message = [&](const Image& message) { image = message; };
  infos.writer->on_message = [&](const CameraInfo& message) { info = message; };
  ASSERT_EQ(turn(loop), Turn::Frame);
  EXPECT_EQ(image.header, info.header);
  EXPECT_EQ(image.header.stamp.sec * 1'000'000'000LL + image.header.stamp.nanosec,
            (clock.wall_now() - 30ms).nanoseconds());
  EXPECT_EQ(info.width, 640U);
  EXPECT_EQ(info.height, 480U);
  EXPECT_EQ(info.k[0], 0.0) << "this camera has no calibration";
}

TEST_F(CaptureLoopTest, converts_and_decodes_into_the_messages_own_memory) {
  const PatternScene scene{640, 480, kRgb24};
  Bytes rgb(scene.frame_bytes());
  scene.render(3, rgb);
  const Bytes jpeg = encode_jpeg(rgb, 640, 480);
  auto loop = make(capture, "rgb8", kMjpeg);
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  ASSERT_TRUE(camera->deliver(0, 0, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, static_cast<long>(jpeg.size())));
  std::copy(jpeg.begin(), jpeg.end(), camera->buffers[0].memory.begin());
  ASSERT_TRUE(camera->deliver(1, 0x77, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, 5000));
  double error = 0;
  images.writer->on_message = [&](const Image& image) {
    ASSERT_EQ(image.data.size(), rgb.size());
    EXPECT_FALSE(image.data.is_foreign());
    for (std::size_t i = 0; i < rgb.size(); ++i) error += std::abs(rgb[i] - image.data[i]);
    error /= static_cast<double>(rgb.size());
  };
  EXPECT_EQ(turn(loop), Turn::Frame);
  EXPECT_LT(error, 4.0);
  EXPECT_EQ(turn(loop), Turn::Frame);
  EXPECT_EQ(loop.stats().published, 1U);
  EXPECT_EQ(loop.stats().undecodable, 1U);
  EXPECT_TRUE(camera->buffers[0].queued && camera->buffers[1].queued);
}

struct JpegLoopTest : CaptureLoopTest {
  void SetUp() override {
    const PatternScene scene{640, 480, kRgb24};
    Bytes rgb(scene.frame_bytes());
    scene.render(3, rgb);
    jpeg = encode_jpeg(rgb, 640, 480);
    CaptureLoop::Settings settings;
    settings.wish.pixel_format = kMjpeg;
    settings.output = find_pixel_format(kRgb24);
    settings.frame_id = "camera_optical_frame";
    loop.emplace(
        CaptureLoop::Surroundings{
            capture, clock, logger, images.publisher, infos.publisher, {}, nullptr, &jpegs.publisher},
        settings);
    ASSERT_TRUE(loop->open());
    ASSERT_TRUE(loop->start());
  }
  void deliver(const Bytes& bytes) {
    const std::uint32_t next = sequence % 6;
    ASSERT_TRUE(camera->deliver(sequence++, 0, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, static_cast<long>(bytes.size())));
    std::copy(bytes.begin(), bytes.end(), camera->buffers[next].memory.begin());
    ASSERT_EQ(turn(*loop), Turn::Frame);
  }
  PooledTopic<CompressedImage> jpegs{8};
  std::optional<CaptureLoop> loop;
  Bytes jpeg;
};

TEST_F(JpegLoopTest, publishes_a_jpeg_as_it_came_in_the_drivers_buffer_and_decodes_it_for_readers_of_the_image) {
  CompressedImage got;
  jpegs.writer->on_message = [&](const CompressedImage& message) {
    EXPECT_EQ(message.data.data(), camera->buffers[0].memory.data());
    EXPECT_FALSE(camera->buffers[0].queued);
    got = message;
  };
  Image image;
  images.writer->on_message = [&](const Image& message) { image = message; };
  deliver(jpeg);
  EXPECT_EQ(got.format, "jpeg");
  EXPECT_TRUE(std::equal(got.data.begin(), got.data.end(), jpeg.begin(), jpeg.end()));
  EXPECT_EQ(got.header, image.header);
  EXPECT_EQ(image.data.size(), 640U * 480U * 3U);
  EXPECT_TRUE(camera->buffers[0].queued);
  EXPECT_EQ(loop->stats().published, 1U);
  EXPECT_EQ(loop->stats().compressed, 1U);
}

TEST_F(JpegLoopTest, decodes_nothing_while_nobody_reads_the_image) {
  images.writer->readers = 0;
  for (int i = 0; i < 10; ++i) deliver(jpeg);
  deliver(Bytes{1, 2, 3});  // as it came: who reads it finds out
  EXPECT_EQ(loop->stats().compressed, 11U);
  EXPECT_EQ(loop->stats().not_decoded, 11U);
  EXPECT_EQ(loop->stats().published + loop->stats().undecodable, 0U);
  EXPECT_EQ(infos.writer->counters().published, 11U);

  images.writer->readers = 1;
  jpegs.writer->readers = 0;
  deliver(jpeg);
  EXPECT_EQ(loop->stats().published, 1U);
  EXPECT_EQ(loop->stats().compressed, 11U);
}

TEST_F(JpegLoopTest, every_frame_is_accounted_for_and_returns_whoever_reads) {
  std::mt19937 random{20261127};
  for (int i = 0; i < 200; ++i) {
    images.writer->readers = random() % 2;
    jpegs.writer->readers = random() % 2;
    deliver(random() % 4 == 0 ? Bytes{0xFF, 0xD8, 1} : jpeg);
  }
  const CaptureLoopStats stats = loop->stats();
  EXPECT_EQ(stats.published + stats.not_decoded + stats.undecodable + stats.no_message, 200U);
  EXPECT_GT(stats.undecodable, 0U);
  EXPECT_TRUE(
      std::all_of(camera->buffers.begin(), camera->buffers.end(), [](const auto& buffer) { return buffer.queued; }));
}

TEST_F(JpegLoopTest, copies_a_jpeg_while_readers_hold_the_other_buffers) {
  images.writer->readers = 0;
  for (int i = 0; i < 3; ++i) {
    jpegs.writer->keep_next = true;
    deliver(jpeg);
  }
  jpegs.writer->on_message = [&](const CompressedImage& message) {
    EXPECT_FALSE(message.data.is_foreign());
    EXPECT_TRUE(std::equal(message.data.begin(), message.data.end(), jpeg.begin(), jpeg.end()));
  };
  camera->deliver(sequence++, 0, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, static_cast<long>(jpeg.size()));
  std::copy(jpeg.begin(), jpeg.end(), camera->buffers[3].memory.begin());
  ASSERT_EQ(turn(*loop), Turn::Frame);
  EXPECT_EQ(loop->stats().compressed, 4U);
  for (Block* block : jpegs.writer->kept) drop_reference(*block);
}

TEST_F(CaptureLoopTest, comes_back_after_a_pulled_cable_within_a_second_of_the_device) {
  auto loop = make(capture, "yuyv");
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  camera->unplug();
  ASSERT_EQ(turn(loop), Turn::Outage);
  EXPECT_FALSE(loop.is_open());
  const MonotonicTime back = clock.now() + 10s;
  while (!loop.is_open() && clock.now() < back + 10s) {
    ASSERT_GT(loop.resume_at(), clock.now()) << "an outage must not spin";
    clock.advance(loop.resume_at() - clock.now());
    if (clock.now() >= back) camera->plug();
    turn(loop);
  }
  EXPECT_LE(clock.now(), back + 1100ms);
  EXPECT_EQ(reopened, 1);
  EXPECT_EQ(loop.stats().outages, 1U);
  EXPECT_EQ(loop.stats().returns, 1U);
  ASSERT_TRUE(camera->deliver(0, 9));
  EXPECT_EQ(turn(loop), Turn::Frame);
}

TEST_F(CaptureLoopTest, survives_two_hundred_unplugs_without_a_leak) {
  set_log_level(LogLevel::Error);  // each of them is worth a line, but not here
  auto loop = make(capture, "yuyv");
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  for (int round = 0; round < 200; ++round) {
    ASSERT_TRUE(camera->deliver(0, 1));
    ASSERT_EQ(turn(loop), Turn::Frame);
    camera->unplug();
    ASSERT_EQ(turn(loop), Turn::Outage);
    camera->plug();
    clock.advance(loop.resume_at() - clock.now());
    turn(loop);
    ASSERT_TRUE(loop.is_open());
  }
  EXPECT_EQ(camera->mapped, 6);
  EXPECT_EQ(camera->open_descriptors.size(), 1U);
  EXPECT_EQ(camera->used_after_close, 0);
  loop.close();
  EXPECT_EQ(camera->mapped, 0);
  EXPECT_TRUE(camera->open_descriptors.empty());
}

TEST_F(CaptureLoopTest, a_dry_pool_costs_frames_and_nothing_else) {
  PooledTopic<Image> two{2};
  CaptureLoop::Settings settings;
  settings.output = find_pixel_format(kYuyv);
  CaptureLoop loop{{capture, clock, logger, two.publisher, infos.publisher, {}}, settings};
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(camera->deliver(sequence++, 1));
    two.writer->keep_next = true;
    ASSERT_EQ(turn(loop), Turn::Frame);
  }
  EXPECT_EQ(loop.stats().published, 2U);
  EXPECT_EQ(loop.stats().no_message, 4U);
  for (Block* block : two.writer->kept) drop_reference(*block);
}

TEST_F(CaptureLoopTest, the_pattern_waits_a_frame_for_a_dry_pool) {
  PatternSource pattern{clock};
  PooledTopic<Image> one{1};
  CaptureLoop::Settings settings;
  settings.wish.pixel_format = kRgb24;
  settings.output = find_pixel_format(kRgb24);
  CaptureLoop loop{{pattern, clock, logger, one.publisher, infos.publisher, {}}, settings};
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  one.writer->keep_next = true;
  ASSERT_EQ(loop.turn(clock.now()), Turn::Frame);
  ASSERT_EQ(loop.turn(clock.now()), Turn::Outage);
  EXPECT_GT(loop.resume_at(), clock.now() + 30ms);
  drop_reference(*one.writer->kept.front());
  clock.advance(40ms);
  EXPECT_EQ(loop.turn(clock.now()), Turn::Frame);
}

// What the report of a run shows as allocations of the thread camera_rx.
class SteadyState : public CaptureLoopTest, public ::testing::WithParamInterface<const char*> {};
TEST_P(SteadyState, allocates_nothing_per_frame) {
  auto loop = make(capture, GetParam());
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  const auto frame = [&] {
    camera->deliver(sequence++, 1);
    return turn(loop);
  };
  for (int i = 0; i < 10; ++i) ASSERT_EQ(frame(), Turn::Frame);
  const auto capture_time = clock.now();
  std::uint64_t allocations = 0;
  for (int i = 0; i < 50; ++i) {
    camera->deliver(sequence++, 1);
    const test::AllocationGuard guard;
    turn(loop);
    allocations += guard.count();
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_EQ(loop.stats().published, 60U);
  EXPECT_EQ(clock.now(), capture_time);
}
INSTANTIATE_TEST_SUITE_P(Encodings, SteadyState, ::testing::Values("yuyv", "rgb8", "bgr8", "mono8"));

TEST_F(CaptureLoopTest, the_pattern_allocates_nothing_per_frame) {
  PatternSource pattern{clock};
  auto loop = make(pattern, "rgb8", kRgb24);
  ASSERT_TRUE(loop.open());
  ASSERT_TRUE(loop.start());
  std::uint64_t allocations = 0;
  for (int i = 0; i < 60; ++i) {
    const test::AllocationGuard guard;
    ASSERT_EQ(loop.turn(clock.now()), Turn::Frame);
    if (i >= 10) allocations += guard.count();
    clock.advance(33333334ns);
  }
  EXPECT_EQ(allocations, 0U);
}

TEST_F(CaptureLoopTest, says_which_encodings_the_camera_can_have) {
  auto loop = make(capture, "yuyv", kMjpeg);
  const auto opened = loop.open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, CameraFault::NotConvertible);
  EXPECT_EQ(opened.error().where, Place::of_parameter("output_encoding"));
  EXPECT_EQ(opened.error().value, "yuyv");
  EXPECT_EQ(opened.error().what, "yuyv cannot be made from MJPG");
  EXPECT_EQ(opened.error().way_out, "use rgb8 or bgr8 or mono8");
  EXPECT_TRUE(camera->open_descriptors.empty());
}

}  // namespace
}  // namespace nacelle::camera
