// SPDX-License-Identifier: Apache-2.0
// LibcameraCapture on libcamera's own virtual pipeline.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "camera/port/camera_fault.hpp"
#include "camera/port/libcamera_capture.hpp"
#include "virtual_cameras.hpp"

namespace nacelle::camera {
namespace {

using test::kPatience;
using ::testing::HasSubstr;

void give_back(const Frame& frame) { frame.return_memory(); }

class VirtualCamera : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_WITH_VIRTUAL_CAMERAS();
    wish_.device = "libcamera:Front";
    wish_.pixel_format = kNv12;
    wish_.width = 320;
    wish_.height = 240;
  }
  /// Opens and starts the port. Returns whether that succeeded.
  [[nodiscard]] bool begin(LibcameraCapture& port) {
    auto agreed = port.open(wish_);
    EXPECT_TRUE(agreed) << agreed.error().text();
    if (!agreed) return false;
    format_ = *agreed;
    const auto started = port.start();
    EXPECT_TRUE(started) << started.error().text();
    return started.has_value();
  }
  [[nodiscard]] Result<Frame, CaptureFault> next(LibcameraCapture& port) {
    return port.next(clock_.now() + kPatience, {});
  }

  SystemClock clock_;
  CaptureWish wish_;
  CaptureFormat format_;
};

TEST_F(VirtualCamera, gives_frames_in_its_own_dma_bufs) {
  LibcameraCapture port{clock_};
  ASSERT_TRUE(begin(port));
  EXPECT_EQ(format_.pixel_format, kNv12);
  EXPECT_EQ(format_.width, 320U);
  EXPECT_EQ(format_.frame_bytes, 320U * 240U * 3U / 2U);
  EXPECT_EQ(format_.camera_name, "virtual_front");
  EXPECT_TRUE(format_.remarks.empty()) << format_.remarks[0];
  std::set<const std::uint8_t*> memory;
  std::uint64_t expected = 0;
  for (int i = 0; i < 20; ++i) {
    const auto frame = next(port);
    ASSERT_TRUE(frame) << to_text(frame.error());
    EXPECT_EQ(frame->bytes.size(), format_.frame_bytes);
    EXPECT_GE(frame->dma_buf, 0);
    EXPECT_EQ(frame->sequence, expected + frame->lost);
    expected = frame->sequence + 1;
    memory.insert(frame->bytes.data());
    // Bars of all brightnesses from left to right, which move.
    const auto line = frame->bytes.first(format_.width);
    EXPECT_GT(*std::max_element(line.begin(), line.end()), 180);
    EXPECT_LT(*std::min_element(line.begin(), line.end()), 40);
    give_back(*frame);
  }
  EXPECT_LE(memory.size(), std::size_t{LibcameraCapture::kBuffers}) << "the same buffers again and again";
  EXPECT_EQ(port.stats().frames, 20U);
  EXPECT_EQ(port.stats().doubtful_stamps, 0U);
}

TEST_F(VirtualCamera, stamps_frames_by_the_sensor_within_the_time_that_the_test_saw) {
  LibcameraCapture port{clock_};
  ASSERT_TRUE(begin(port));
  const WallTime before = clock_.wall_now();
  WallTime last = before - 1s;
  for (int i = 0; i < 5; ++i) {
    const auto frame = next(port);
    ASSERT_TRUE(frame);
    EXPECT_GT(frame->captured, last);
    EXPECT_LE(frame->captured, frame->received + 1ms);
    EXPECT_LE(frame->received, clock_.wall_now());
    last = frame->captured;
    give_back(*frame);
  }
}

TEST_F(VirtualCamera, frames_stay_readable_after_the_stream_and_the_camera_starts_again_meanwhile) {
  LibcameraCapture port{clock_};
  ASSERT_TRUE(begin(port));
  const auto kept = next(port);
  ASSERT_TRUE(kept);
  const std::vector<std::uint8_t> content(kept->bytes.begin(), kept->bytes.end());
  port.close();
  ASSERT_TRUE(begin(port));
  const auto other = next(port);
  ASSERT_TRUE(other);
  EXPECT_NE(other->bytes.data(), kept->bytes.data());
  EXPECT_TRUE(std::equal(content.begin(), content.end(), kept->bytes.begin()));
  give_back(*other);
  give_back(*kept);
}

TEST_F(VirtualCamera, waits_without_a_buffer_and_continues_when_a_reader_gives_one_back) {
  LibcameraCapture port{clock_};
  ASSERT_TRUE(begin(port));
  std::vector<Frame> held;
  for (;;) {
    // With every buffer in the reader's hands, no frame can come.
    const bool starves = !held.empty() && held.back().spare_buffers == 0;
    const auto frame = starves ? port.next(clock_.now() + 1s, {}) : next(port);
    if (!frame && starves) break;
    ASSERT_TRUE(frame) << to_text(frame.error());
    held.push_back(*frame);
    ASSERT_LE(held.size(), 32U);
  }
  EXPECT_GE(port.stats().starved, 1U);
  for (const Frame& frame : held) give_back(frame);
  const auto frame = next(port);
  ASSERT_TRUE(frame);
  give_back(*frame);
}

TEST_F(VirtualCamera, takes_the_nearest_size_and_lists_what_there_is) {
  wish_.width = 600;
  wish_.height = 470;
  LibcameraCapture port{clock_};
  ASSERT_TRUE(begin(port));
  EXPECT_NE(format_.width, 600U);
  ASSERT_FALSE(format_.remarks.empty());
  EXPECT_THAT(format_.remarks[0], HasSubstr("image_size [600, 470] is not offered"));
}

TEST_F(VirtualCamera, takes_another_layout_if_it_lacks_the_wished_one) {
  wish_.pixel_format = kMjpeg;
  LibcameraCapture port{clock_};
  ASSERT_TRUE(begin(port));
  EXPECT_EQ(format_.pixel_format, kNv12);
  ASSERT_FALSE(format_.remarks.empty());
  EXPECT_THAT(format_.remarks[0], HasSubstr("pixel_format MJPG is not offered (NV12); NV12 is used"));
}

TEST_F(VirtualCamera, is_busy_while_another_port_has_it_and_another_camera_is_not) {
  LibcameraCapture first{clock_}, second{clock_};
  ASSERT_TRUE(begin(first));
  const auto refused = second.open(wish_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, CameraFault::Busy);
  EXPECT_THAT(refused.error().text(), HasSubstr("libcamera:Front: acquire failed: Device or resource busy"));
  wish_.device = "libcamera:Back";
  ASSERT_TRUE(begin(second));
  const auto frame = next(second);
  ASSERT_TRUE(frame);
  give_back(*frame);
  first.close();
  wish_.device = "libcamera:Front";
  second.close();
  EXPECT_TRUE(begin(second));
}

TEST_F(VirtualCamera, is_found_by_its_number_and_an_unknown_name_lists_the_others) {
  LibcameraCapture port{clock_};
  for (const char* const name : {"libcamera", "libcamera:1"}) {
    wish_.device = name;
    EXPECT_TRUE(port.open(wish_)) << name;
  }
  for (const char* const name : {"libcamera:Fronk", "libcamera:2", "libcamera:"}) {
    wish_.device = name;
    const auto refused = port.open(wish_);
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().code, CameraFault::NotThere);
    EXPECT_THAT(refused.error().text(), HasSubstr("libcamera has no such camera, only "));
    EXPECT_THAT(refused.error().text(), HasSubstr("Front"));
  }
}

TEST_F(VirtualCamera, refuses_memory_that_is_not_libcameras) {
  LibcameraCapture port{clock_};
  wish_.memory = FrameMemory::Own;
  const auto refused = port.open(wish_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, CameraFault::MemoryRefused);
}

TEST_F(VirtualCamera, an_interrupt_ends_the_wait) {
  LibcameraCapture port{clock_};
  ASSERT_TRUE(begin(port));
  port.interrupt();
  const auto woken = next(port);
  ASSERT_FALSE(woken);
  EXPECT_EQ(woken.error(), CaptureFault::NoFrame);
}

TEST_F(VirtualCamera, leaks_no_descriptor_and_no_thread_over_many_streams) {
  LibcameraCapture port{clock_};
  const auto stream_once = [&] {
    ASSERT_TRUE(begin(port));
    const auto frame = next(port);
    ASSERT_TRUE(frame);
    give_back(*frame);
    port.close();
  };
  ASSERT_NO_FATAL_FAILURE(stream_once());  // what is made once
  const auto files = test::count_entries("/proc/self/fd"), threads = test::count_entries("/proc/self/task");
  for (int cycle = 0; cycle < test::cycles(); ++cycle) ASSERT_NO_FATAL_FAILURE(stream_once());
  EXPECT_EQ(test::count_entries("/proc/self/fd"), files);
  EXPECT_EQ(test::count_entries("/proc/self/task"), threads);
}

// The last one: a search that finds no configuration is the virtual pipeline's last in a process (libcamera 0.4.0).
TEST(NoCamera, is_explained_by_what_to_look_at_on_a_pi) {
  NACELLE_ONLY_IN_MACHINE("libcamera");
  std::filesystem::remove_all("/usr/share/libcamera/pipeline/virtual");
  const SystemClock clock;
  LibcameraCapture port{clock};
  CaptureWish wish;
  wish.device = "libcamera";
  const auto refused = port.open(wish);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, CameraFault::NotThere);
  EXPECT_THAT(refused.error().text(), HasSubstr("libcamera: libcamera sees no camera"));
  EXPECT_THAT(refused.error().way_out, HasSubstr("camera_auto_detect=1 in /boot/firmware/config.txt"));
}

}  // namespace
}  // namespace nacelle::camera
