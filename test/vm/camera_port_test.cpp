// SPDX-License-Identifier: Apache-2.0
// V4l2Capture on the kernel's virtual camera.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>

#include "camera/port/camera_fault.hpp"
#include "camera/port/v4l2_capture.hpp"
#include "vivid.hpp"

namespace nacelle::camera {
namespace {

using test::kPatience;
using test::Vivid;

void give_back(const Frame& frame) {
  if (frame.give_back.release != nullptr) frame.give_back.release(frame.give_back.context);
}

class CameraPort : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("camera");
    Vivid::calm();
    wish_.width = 320;
    wish_.height = 180;
  }
  /// Opens and starts the port. Returns whether that succeeded.
  [[nodiscard]] bool begin(V4l2Capture& port) {
    auto agreed = port.open(wish_);
    EXPECT_TRUE(agreed) << agreed.error().text();
    if (!agreed) return false;
    format_ = *agreed;
    const auto started = port.start();
    EXPECT_TRUE(started) << started.error().text();
    return started.has_value();
  }
  [[nodiscard]] Result<Frame, CaptureFault> next(V4l2Capture& port) { return port.next(clock_.now() + kPatience, {}); }
  /// The fault with which a stream ends, after any number of frames.
  [[nodiscard]] CaptureFault end_of(V4l2Capture& port) {
    for (;;) {
      const auto frame = next(port);
      if (!frame) return frame.error();
      give_back(*frame);
    }
  }
  /// One frame, as v4l2-ctl captures it.
  [[nodiscard]] Bytes captured_by_v4l2_ctl(const std::string& pixel_format) const {
    const std::string file = "/tmp/frame";
    const std::string command = "v4l2-ctl -d " + Vivid::kCamera + " -v width=" + std::to_string(wish_.width) +
                                ",height=" + std::to_string(wish_.height) + ",pixelformat=" + pixel_format +
                                " --stream-mmap --stream-count=1 --stream-to=" + file + " 2>&1 >/dev/null";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    std::ifstream stream{file, std::ios::binary};
    return {std::istreambuf_iterator<char>{stream}, {}};
  }

  SystemClock clock_;
  CaptureWish wish_;
  CaptureFormat format_;
};

TEST_F(CameraPort, delivers_every_frame_in_order_with_the_time_of_its_capture) {
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  EXPECT_EQ(format_.width, 320U);
  EXPECT_EQ(format_.frame_bytes, 320U * 180U * 2U);
  EXPECT_EQ(format_.camera_name, "vivid");
  std::optional<WallTime> before;
  std::uint64_t expected = 0;
  for (int i = 0; i < 30; ++i) {
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    EXPECT_EQ(frame->sequence, expected + frame->lost);
    expected = frame->sequence + 1;
    EXPECT_TRUE(!before || frame->captured > *before);
    EXPECT_LE(frame->captured, frame->received);
    before = frame->captured;
    give_back(*frame);
  }
  const CaptureStats stats = port.stats();
  EXPECT_EQ(stats.frames, 30U);
  EXPECT_EQ(stats.damaged + stats.torn + stats.starved + stats.doubtful_stamps, 0U);
}

/// Pixel formats that vivid offers and the driver reads.
class CameraFormat : public CameraPort, public ::testing::WithParamInterface<const char*> {};

TEST_P(CameraFormat, has_the_bytes_that_v4l2_ctl_captures) {
  wish_.pixel_format = *parse_fourcc(GetParam());
  const Bytes theirs = captured_by_v4l2_ctl(GetParam());
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  EXPECT_EQ(to_text(format_.pixel_format), GetParam());
  const auto frame = next(port);
  ASSERT_TRUE(frame) << to_text(frame.error());
  EXPECT_EQ(frame->bytes.size(), theirs.size());
  EXPECT_TRUE(std::equal(frame->bytes.begin(), frame->bytes.end(), theirs.begin(), theirs.end()));
  give_back(*frame);
}
INSTANTIATE_TEST_SUITE_P(Kernel, CameraFormat,
                         ::testing::Values("YUYV", "UYVY", "RGB3", "BGR3", "NV12", "GREY", "BA81", "GBRG", "GRBG",
                                           "RGGB"),
                         [](const auto& test) { return std::string{test.param}; });

TEST_F(CameraPort, the_time_of_capture_follows_a_step_of_the_clock) {
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  const auto before = next(port);
  ASSERT_TRUE(before) << to_text(before.error());
  give_back(*before);
  const auto step_clock = [](std::int64_t seconds) {
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    now.tv_sec += seconds;
    EXPECT_EQ(::clock_settime(CLOCK_REALTIME, &now), 0);
  };
  step_clock(3600);
  for (int i = 0; i < 8; ++i) {  // those that were captured before the step as well
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    EXPECT_GE(frame->captured - before->captured, 3600s);
    EXPECT_LE(frame->captured, frame->received);
    give_back(*frame);
  }
  step_clock(-3600);
}

/// Three laps through all buffers, all with the picture that v4l2-ctl captures.
class CameraMemory : public CameraPort {
 protected:
  void expect_pictures(V4l2Capture& port, const std::function<void(const Frame&)>& check = {}) {
    const Bytes theirs = captured_by_v4l2_ctl("YUYV");
    ASSERT_TRUE(begin(port));
    for (int i = 0; i < 18; ++i) {
      const auto frame = next(port);
      ASSERT_TRUE(frame) << to_text(frame.error());
      EXPECT_TRUE(std::equal(frame->bytes.begin(), frame->bytes.end(), theirs.begin(), theirs.end())) << "frame " << i;
      if (check) check(*frame);
      give_back(*frame);
    }
  }
};

TEST_F(CameraMemory, of_this_process_is_filled_by_the_driver) {
  wish_.memory = FrameMemory::Own;
  V4l2Capture port{clock_};
  expect_pictures(port);
}

TEST_F(CameraMemory, of_the_driver_is_exported_for_other_devices) {
  wish_.export_frames = true;
  V4l2Capture port{clock_};
  const auto files = test::count_entries("/proc/self/fd");
  expect_pictures(port, [](const Frame& frame) {
    ASSERT_GE(frame.dma_buf, 0);
    void* const theirs = ::mmap(nullptr, frame.bytes.size(), PROT_READ, MAP_SHARED, frame.dma_buf, 0);
    ASSERT_NE(theirs, MAP_FAILED) << "errno " << errno;
    EXPECT_EQ(std::memcmp(theirs, frame.bytes.data(), frame.bytes.size()), 0);
    ::munmap(theirs, frame.bytes.size());
  });
  port.close();
  EXPECT_EQ(test::count_entries("/proc/self/fd"), files);
}

// The other device is vivid's output, whose buffers are exported.
TEST_F(CameraMemory, of_another_device_is_filled_by_the_driver) {
  const test::ExportedBuffers other{Vivid::kOutput, wish_.width, wish_.height, 6};
  wish_.memory = FrameMemory::Imported;
  wish_.imports = other.dma_bufs();
  ASSERT_EQ(wish_.imports.size(), 6U);
  V4l2Capture port{clock_};
  expect_pictures(port, [&](const Frame& frame) {
    EXPECT_THAT(wish_.imports, ::testing::Contains(frame.dma_buf));
    EXPECT_TRUE(other.holds(frame.dma_buf, frame.bytes));
  });
}

TEST_F(CameraMemory, of_another_device_that_is_too_small_is_refused_with_the_way_out) {
  const test::ExportedBuffers other{Vivid::kOutput, 320, 180, 6};
  wish_.width = 640;
  wish_.height = 360;
  wish_.memory = FrameMemory::Imported;
  wish_.imports = other.dma_bufs();
  V4l2Capture port{clock_};
  ASSERT_TRUE(port.open(wish_));
  const auto started = port.start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().text(), ::testing::HasSubstr("each as large as a frame"));
}

TEST_F(CameraPort, takes_the_nearest_mode_and_lists_what_there_is) {
  wish_.width = 700;
  wish_.height = 500;
  wish_.pixel_format = kMjpeg;
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  EXPECT_EQ(to_text(format_.pixel_format), "YUYV");
  const std::string remarks = ::testing::PrintToString(format_.remarks);
  EXPECT_THAT(remarks, ::testing::HasSubstr("pixel_format MJPG is not offered (YUYV, UYVY, "));
  EXPECT_THAT(remarks,
              ::testing::HasSubstr("image_size [700, 500] is not offered (320x180, 640x360, 640x480, 1280x720"));
}

TEST_F(CameraPort, says_that_another_program_streams) {
  V4l2Capture first{clock_}, second{clock_};
  ASSERT_TRUE(begin(first));
  const auto agreed = second.open(wish_);
  ASSERT_FALSE(agreed.has_value() && second.start().has_value());
  if (!agreed) { EXPECT_THAT(agreed.error().text(), ::testing::HasSubstr("another program uses it")); }
}

TEST_F(CameraPort, an_output_is_no_camera) {
  wish_.device = Vivid::kOutput;
  V4l2Capture port{clock_};
  const auto agreed = port.open(wish_);
  ASSERT_FALSE(agreed);
  EXPECT_THAT(agreed.error().text(), ::testing::HasSubstr("is not a camera that streams ('vivid'"));
}

TEST_F(CameraPort, counts_what_the_driver_drops) {
  Vivid::set(Vivid::DroppedPercent, 50);
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  std::uint64_t last = 0, lost = 0;
  for (int i = 0; i < 20; ++i) {
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    last = frame->sequence;
    lost += frame->lost;
    give_back(*frame);
  }
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(port.stats().lost, lost);
  EXPECT_EQ(last + 1, 20 + lost) << "every frame is delivered or counted";
}

TEST_F(CameraPort, skips_a_damaged_frame_and_counts_it) {
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  Vivid::press(Vivid::DamagedBuffer);
  while (port.stats().damaged == 0) {
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    give_back(*frame);
  }
  const auto frame = next(port);
  ASSERT_TRUE(frame) << to_text(frame.error());
  give_back(*frame);
  EXPECT_EQ(port.stats().damaged, 1U);
}

// vivid's counter then begins 128 frames before its end.
TEST_F(CameraPort, a_counter_that_wraps_is_no_loss) {
  Vivid::set(Vivid::WrapSequence, 1);
  wish_.period_den = 60;
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  std::uint64_t last = 0, lost = 0;
  while (last < 140) {
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    EXPECT_TRUE(frame->sequence == 0 || frame->sequence == last + 1 + frame->lost);
    last = frame->sequence;
    lost += frame->lost;
    give_back(*frame);
  }
  EXPECT_LT(lost, 140U) << "a wrapped counter was taken for a loss";
}

TEST_F(CameraPort, a_refused_step_of_the_start_is_named_and_the_next_start_succeeds) {
  for (const auto& [button, step] :
       {std::pair{Vivid::RefuseBuffers, "REQBUFS"}, std::pair{Vivid::RefuseStream, "STREAMON"}}) {
    Vivid::press(button);
    V4l2Capture port{clock_};
    ASSERT_TRUE(port.open(wish_));
    const auto started = port.start();
    ASSERT_FALSE(started);
    EXPECT_THAT(started.error().text(), ::testing::HasSubstr(step));
    ASSERT_TRUE(begin(port));
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    give_back(*frame);
  }
}

TEST_F(CameraPort, an_error_of_the_stream_breaks_it_and_a_new_start_mends_it) {
  for (const auto button : {Vivid::FatalError, Vivid::RefuseQueueing}) {
    V4l2Capture port{clock_};
    ASSERT_TRUE(begin(port));
    Vivid::press(button);
    EXPECT_EQ(end_of(port), CaptureFault::Broken);
    ASSERT_TRUE(begin(port));
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    give_back(*frame);
  }
}

TEST_F(CameraPort, a_disconnected_camera_is_gone_and_comes_back) {
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  Vivid::press(Vivid::Disconnect);
  EXPECT_EQ(end_of(port), CaptureFault::Gone);
  port.close();
  ASSERT_TRUE(begin(port));
  const auto frame = next(port);
  ASSERT_TRUE(frame) << to_text(frame.error());
  give_back(*frame);
}

TEST_F(CameraPort, a_frame_outlives_its_camera) {
  V4l2Capture port{clock_};
  ASSERT_TRUE(begin(port));
  const auto frame = next(port);
  ASSERT_TRUE(frame) << to_text(frame.error());
  const Bytes before{frame->bytes.begin(), frame->bytes.end()};
  Vivid::press(Vivid::Disconnect);
  EXPECT_EQ(end_of(port), CaptureFault::Gone);
  port.close();
  EXPECT_TRUE(std::equal(before.begin(), before.end(), frame->bytes.begin()));
  // Although it is still held, the next stream begins.
  ASSERT_TRUE(begin(port));
  const auto later = next(port);
  ASSERT_TRUE(later) << to_text(later.error());
  EXPECT_TRUE(std::equal(before.begin(), before.end(), frame->bytes.begin()));
  give_back(*frame);
  give_back(*later);
}

}  // namespace
}  // namespace nacelle::camera
