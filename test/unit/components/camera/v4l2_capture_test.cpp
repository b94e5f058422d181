// SPDX-License-Identifier: Apache-2.0
#include "camera/port/v4l2_capture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <random>
#include <thread>

#include "camera/port/camera_fault.hpp"
#include "camera/port/v4l2_negotiation.hpp"
#include "scripted_camera.hpp"

namespace nacelle::camera {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

void give_back(const Frame& frame) { frame.give_back.release(frame.give_back.context); }

struct V4l2CaptureTest : ::testing::Test {
  CaptureFormat begin(const CaptureWish& wish = {}) {
    auto format = capture.open(wish);
    EXPECT_TRUE(format) << (format ? "" : format.error().text());
    const auto started = capture.start();
    EXPECT_TRUE(started) << (started ? "" : started.error().text());
    return format.value();
  }
  Result<Frame, CaptureFault> next() { return capture.next(clock.now() + 100ms, {}); }

  test::ManualClock clock;
  std::shared_ptr<ScriptedCamera> camera = std::make_shared<ScriptedCamera>(clock);
  V4l2Capture capture{clock, camera};
};

TEST_F(V4l2CaptureTest, gives_the_drivers_own_memory_and_takes_it_back_through_the_hook) {
  const CaptureFormat format = begin();
  EXPECT_EQ(format.bytes_per_line, 1280U);
  EXPECT_EQ(format.frame_bytes, 614400U);
  EXPECT_EQ(format.camera_name, "hd_webcam_front");
  EXPECT_TRUE(format.remarks.empty());
  ASSERT_TRUE(camera->deliver(0, 0x5A));

  const auto frame = next();

  ASSERT_TRUE(frame);
  EXPECT_EQ(frame.value().bytes.data(), camera->buffers[0].memory.data());
  EXPECT_EQ(frame.value().bytes[1000], 0x5A);
  EXPECT_FALSE(camera->buffers[0].queued);
  give_back(frame.value());
  EXPECT_TRUE(camera->buffers[0].queued);
}

TEST_F(V4l2CaptureTest, makes_three_calls_a_frame) {
  begin();
  camera->calls.clear();
  camera->waits = 0;
  const int frames = 50;
  for (int i = 0; i < frames; ++i) {
    ASSERT_TRUE(camera->deliver(static_cast<std::uint32_t>(i), 1));
    const auto frame = next();
    ASSERT_TRUE(frame);
    give_back(frame.value());
  }
  int controls = 0;
  for (const auto& [request, count] : camera->calls) controls += count;
  EXPECT_EQ(camera->waits, frames);
  EXPECT_EQ(controls, 2 * frames);
  EXPECT_EQ(camera->calls[VIDIOC_DQBUF], frames);
}

TEST_F(V4l2CaptureTest, counts_gaps_of_the_sequence_as_lost) {
  begin();
  std::vector<std::uint64_t> numbers;
  for (const std::uint32_t sequence : {0U, 1U, 4U, 5U}) {
    ASSERT_TRUE(camera->deliver(sequence, 1));
    const auto frame = next();
    ASSERT_TRUE(frame);
    numbers.push_back(frame.value().sequence);
    give_back(frame.value());
  }
  EXPECT_EQ(numbers, (std::vector<std::uint64_t>{0, 1, 4, 5}));
  EXPECT_EQ(capture.stats().lost, 2U);
  EXPECT_EQ(capture.stats().frames, 4U);
}

TEST_F(V4l2CaptureTest, skips_and_requeues_damaged_and_torn_frames) {
  begin();
  ASSERT_TRUE(camera->deliver(0, 1, V4L2_BUF_FLAG_ERROR | V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC));
  ASSERT_TRUE(camera->deliver(1, 1, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, 1000));
  ASSERT_TRUE(camera->deliver(2, 7));

  const auto frame = next();

  ASSERT_TRUE(frame);
  EXPECT_EQ(frame.value().bytes[0], 7);
  EXPECT_EQ(frame.value().sequence, 2U);
  EXPECT_EQ(capture.stats().damaged, 1U);
  EXPECT_EQ(capture.stats().torn, 1U);
  EXPECT_EQ(capture.stats().lost, 0U);
  EXPECT_TRUE(camera->buffers[0].queued && camera->buffers[1].queued);
  give_back(frame.value());
}

TEST_F(V4l2CaptureTest, takes_fewer_buffers_than_it_asked_for) {
  camera->most_buffers = 2;
  begin();
  ASSERT_TRUE(camera->deliver(0, 1));
  ASSERT_TRUE(camera->deliver(1, 2));
  const auto first = next(), second = next();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second.value().spare_buffers, 0U);

  // Every buffer is out: the device reports an error to poll(), which must not be mistaken for a broken stream.
  EXPECT_EQ(next().error(), CaptureFault::NoFrame);
  give_back(first.value());
  ASSERT_TRUE(camera->deliver(2, 3));
  const auto third = next();
  ASSERT_TRUE(third);
  give_back(second.value());
  give_back(third.value());
}

TEST_F(V4l2CaptureTest, says_when_the_driver_has_no_memory_for_buffers) {
  camera->most_buffers = 0;
  ASSERT_TRUE(capture.open({}));
  const auto started = capture.start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, CameraFault::NoMemory);
  EXPECT_THAT(started.error().text(), AllOf(HasSubstr("REQBUFS failed: Cannot allocate memory (errno 12)"),
                                            HasSubstr("no memory for its buffers; choose a smaller image_size")));
  EXPECT_TRUE(camera->open_descriptors.empty());
}

TEST_F(V4l2CaptureTest, repeats_what_a_signal_interrupts_and_waits_on_after_an_empty_wake_up) {
  begin();
  ASSERT_TRUE(camera->deliver(0, 1));
  camera->fail_next(VIDIOC_DQBUF, -EINTR);
  camera->fail_next(VIDIOC_DQBUF, -EAGAIN);
  const auto frame = next();
  ASSERT_TRUE(frame);
  camera->fail_next(VIDIOC_QBUF, -EINTR);
  give_back(frame.value());
  EXPECT_TRUE(camera->buffers[0].queued);
}

TEST_F(V4l2CaptureTest, an_error_of_the_queue_means_a_broken_stream) {
  begin();
  ASSERT_TRUE(camera->deliver(0, 1));
  camera->fail_next(VIDIOC_DQBUF, -EIO);
  EXPECT_EQ(next().error(), CaptureFault::Broken);
}

TEST_F(V4l2CaptureTest, silence_of_a_second_means_a_broken_stream) {
  begin();
  int quiet_waits = 0;
  CaptureFault fault = CaptureFault::NoFrame;
  while (fault == CaptureFault::NoFrame && quiet_waits < 100) {
    fault = next().error();
    ++quiet_waits;
  }
  EXPECT_EQ(fault, CaptureFault::Broken);
  EXPECT_EQ(quiet_waits, 12);  // 100 ms each, the eleventh ends at 1.1 s
}

TEST_F(V4l2CaptureTest, survives_a_pulled_cable_with_a_frame_in_a_readers_hand) {
  begin();
  ASSERT_TRUE(camera->deliver(0, 0x11));
  const auto held = next();
  ASSERT_TRUE(held);

  camera->unplug();
  EXPECT_EQ(next().error(), CaptureFault::Gone);
  capture.close();
  EXPECT_TRUE(camera->open_descriptors.empty());
  EXPECT_EQ(held.value().bytes[5], 0x11);
  EXPECT_GT(camera->mapped, 0);
  EXPECT_EQ(capture.open({}).error().code, CameraFault::NotThere);

  camera->plug();
  begin();
  ASSERT_TRUE(camera->deliver(0, 0x22));
  const auto frame = next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(held.value().bytes[5], 0x11);
  give_back(held.value());
  give_back(frame.value());
  EXPECT_EQ(camera->used_after_close, 0);
  EXPECT_EQ(camera->mapped, 6);  // of the stream that runs
}

// A mapping keeps the device's file open, and with it the stream and the device's number.
TEST_F(V4l2CaptureTest, keeps_no_mapping_of_a_closed_device_because_a_reader_holds_a_frame) {
  begin();
  capture.close();
  EXPECT_EQ(camera->detached, 0) << "no frame was out";
  EXPECT_EQ(camera->calls[VIDIOC_REQBUFS], 2)
      << "the buffers were not given back: the next stream would find the device busy";

  begin();
  ASSERT_TRUE(camera->deliver(0, 0x11));
  const auto held = next();
  ASSERT_TRUE(held);
  capture.close();
  EXPECT_EQ(camera->detached, 6);
  give_back(held.value());
}

TEST_F(V4l2CaptureTest, has_frames_in_memory_of_this_process_on_request) {
  CaptureWish wish;
  wish.memory = FrameMemory::Own;
  begin(wish);
  EXPECT_EQ(camera->mapped, 6);
  for (std::uint32_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(camera->deliver(i, static_cast<std::uint8_t>(i)));
    const auto frame = next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->bytes.data(), camera->buffers[i % 6].user);
    EXPECT_EQ(frame->bytes[7], i);
    give_back(frame.value());
  }
  capture.close();
  EXPECT_EQ(camera->mapped, 0);
}

TEST_F(V4l2CaptureTest, says_that_the_driver_takes_no_memory_of_this_process) {
  camera->takes_user_memory = false;
  CaptureWish wish;
  wish.memory = FrameMemory::Own;
  ASSERT_TRUE(capture.open(wish));
  const auto started = capture.start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, CameraFault::MemoryRefused);
  EXPECT_THAT(started.error().text(),
              AllOf(HasSubstr("does not take frame memory of this process"), HasSubstr("use io_method mmap")));
}

TEST_F(V4l2CaptureTest, a_hook_that_finds_the_cable_pulled_ends_the_stream) {
  begin();
  ASSERT_TRUE(camera->deliver(0, 1));
  const auto frame = next();
  ASSERT_TRUE(frame);
  camera->unplug();
  give_back(frame.value());
  EXPECT_EQ(next().error(), CaptureFault::Gone);
}

TEST_F(V4l2CaptureTest, leaves_no_mapping_and_no_descriptor_behind) {
  for (int round = 0; round < 3; ++round) {
    begin();
    ASSERT_TRUE(camera->deliver(0, 1));
    const auto frame = next();
    ASSERT_TRUE(frame);
    capture.close();
    give_back(frame.value());
    EXPECT_EQ(camera->mapped, 0);
    EXPECT_TRUE(camera->open_descriptors.empty());
  }
  EXPECT_EQ(camera->used_after_close, 0);
}

TEST_F(V4l2CaptureTest, every_delivered_frame_is_accounted_for_whatever_the_readers_do) {
  const unsigned seed = 20261121;
  std::mt19937 random{seed};
  begin();
  std::vector<Frame> held;
  std::uint32_t sequence = 0;
  std::uint64_t delivered = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | (random() % 10 == 0 ? V4L2_BUF_FLAG_ERROR : 0);
    if (camera->deliver(sequence++, 1, flags, random() % 10 == 0 ? 100 : -1)) ++delivered;
    const auto frame = capture.next(clock.now(), {});
    if (frame) held.push_back(frame.value());
    if (!frame) { ASSERT_EQ(frame.error(), CaptureFault::NoFrame) << "seed " << seed << ", step " << i; }
    while (!held.empty() && random() % 2 == 0) {
      std::swap(held[random() % held.size()], held.back());
      give_back(held.back());
      held.pop_back();
    }
  }
  const CaptureStats stats = capture.stats();
  EXPECT_EQ(stats.frames + stats.damaged + stats.torn, delivered);
  EXPECT_GT(stats.frames, 1000U);
  for (const Frame& frame : held) give_back(frame);
}

TEST_F(V4l2CaptureTest, takes_frames_back_from_other_threads_also_after_the_stream_is_gone) {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Frame> out;
  bool done = false;
  std::thread reader{[&] {
    for (;;) {
      std::unique_lock lock{mutex};
      changed.wait(lock, [&] { return done || !out.empty(); });
      if (out.empty()) return;
      const Frame frame = out.front();
      out.pop_front();
      lock.unlock();
      give_back(frame);
    }
  }};
  std::uint64_t frames = 0;
  for (int stream = 0; stream < 50; ++stream) {
    begin();
    for (std::uint32_t i = 0; i < 40; ++i) {
      camera->deliver(i, 1);
      const auto frame = capture.next(clock.now(), {});
      if (!frame) continue;
      ++frames;
      const std::lock_guard lock{mutex};
      out.push_back(frame.value());
      changed.notify_one();
    }
    capture.close();
  }
  {
    const std::lock_guard lock{mutex};
    done = true;
  }
  changed.notify_one();
  reader.join();
  EXPECT_GT(frames, 50U);
  EXPECT_EQ(camera->mapped, 0);
  EXPECT_EQ(camera->used_after_close, 0);
}

TEST_F(V4l2CaptureTest, stamps_with_the_kernels_time_on_the_wall_clock_of_the_moment) {
  begin();
  ASSERT_TRUE(camera->deliver(0, 1, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, -1, 20ms));
  const auto first = next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first.value().captured, clock.wall_now() - 20ms);
  give_back(first.value());

  clock.step_wall(3600s);
  ASSERT_TRUE(camera->deliver(1, 1, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, -1, 20ms));
  const auto second = next();
  ASSERT_TRUE(second);
  EXPECT_EQ(second.value().captured, clock.wall_now() - 20ms);
  give_back(second.value());
}

TEST_F(V4l2CaptureTest, takes_the_time_of_receipt_when_the_drivers_makes_no_sense) {
  begin();
  ASSERT_TRUE(camera->deliver(0, 1, V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN, -1, 20ms));
  ASSERT_TRUE(camera->deliver(1, 1, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC, -1, -std::chrono::hours{5}));
  for (int i = 0; i < 2; ++i) {
    const auto frame = next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame.value().captured, clock.wall_now());
    give_back(frame.value());
  }
  EXPECT_EQ(capture.stats().doubtful_stamps, 1U);
}

TEST_F(V4l2CaptureTest, an_interrupt_ends_one_wait_and_only_one) {
  begin();
  capture.interrupt();
  const MonotonicTime before = clock.now();
  EXPECT_EQ(next().error(), CaptureFault::NoFrame);
  EXPECT_EQ(clock.now(), before);
  EXPECT_EQ(next().error(), CaptureFault::NoFrame);
  EXPECT_EQ(clock.now(), before + 100ms);
}

TEST_F(V4l2CaptureTest, uses_the_nearest_mode_of_the_device_and_reports_it) {
  camera->formats = {V4L2_PIX_FMT_H264, V4L2_PIX_FMT_MJPEG};
  CaptureWish wish;
  wish.width = 1920;
  wish.height = 1080;
  wish.period_den = 60;
  const CaptureFormat format = begin(wish);
  EXPECT_EQ(format.pixel_format, kMjpeg);
  EXPECT_EQ(format.width, 640U);
  EXPECT_EQ(format.bytes_per_line, 0U);
  ASSERT_EQ(format.remarks.size(), 3U);
  EXPECT_THAT(format.remarks[0], HasSubstr("YUYV is not offered (H264, MJPG)"));
  EXPECT_THAT(format.remarks[1], HasSubstr("640x480, 320x240"));
  EXPECT_THAT(format.remarks[2], HasSubstr("[1, 60] is not offered"));
}

TEST_F(V4l2CaptureTest, keeps_the_drivers_padding_of_lines) {
  camera->padding = 64;
  const CaptureFormat format = begin();
  EXPECT_EQ(format.bytes_per_line, 1344U);
  EXPECT_EQ(format.frame_bytes, 1344U * 480U);
}

struct OpenCase {
  int answer;
  CameraFault fault;
  const char* way_out;
};
class OpenFaults : public V4l2CaptureTest, public ::testing::WithParamInterface<OpenCase> {};
TEST_P(OpenFaults, name_device_cause_and_way_out) {
  camera->open_answer = GetParam().answer;
  CaptureWish wish;
  wish.device = "/dev/v4l/by-id/front";
  const auto opened = capture.open(wish);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, GetParam().fault);
  EXPECT_EQ(opened.error().where, Place(wish.device));
  EXPECT_THAT(opened.error().what, HasSubstr("errno " + std::to_string(-GetParam().answer)));
  EXPECT_THAT(opened.error().way_out, HasSubstr(GetParam().way_out));
}
INSTANTIATE_TEST_SUITE_P(All, OpenFaults,
                         ::testing::Values(OpenCase{-ENOENT, CameraFault::NotThere, "plugged in"},
                                           OpenCase{-EACCES, CameraFault::NotPermitted, "group video"},
                                           OpenCase{-EBUSY, CameraFault::Busy, "another program"},
                                           OpenCase{-ENODEV, CameraFault::Unplugged, "unplugged"},
                                           OpenCase{-EPIPE, CameraFault::NeedsLibcamera, "libcamera"},
                                           OpenCase{-EINVAL, CameraFault::NotACamera, "`v4l2-ctl --list-devices`"},
                                           OpenCase{-EIO, CameraFault::Failed, "see `dmesg`"}));

TEST_F(V4l2CaptureTest, refuses_a_node_that_is_no_camera) {
  camera->capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  const auto opened = capture.open({});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, CameraFault::NotACamera);
  EXPECT_THAT(opened.error().what, HasSubstr("not a camera that streams"));
  EXPECT_TRUE(camera->open_descriptors.empty());
}

TEST_F(V4l2CaptureTest, refuses_a_sensor_that_gives_raw_data_only) {
  camera->formats = {V4L2_PIX_FMT_SRGGB10P};
  const auto opened = capture.open({});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, CameraFault::UnreadableFormat);
  EXPECT_EQ(opened.error().value, "pRAA");
  EXPECT_EQ(opened.error().what, "offers no pixel format that can be read, only pRAA");
  EXPECT_THAT(opened.error().way_out, HasSubstr("libcamera"));
}

TEST_F(V4l2CaptureTest, refuses_a_size_that_no_picture_has) {
  camera->sizes = {{640, 0}};
  const auto opened = capture.open({});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, CameraFault::UnusableSize);
  EXPECT_EQ(opened.error().value, "640x0");
  EXPECT_EQ(opened.error().what, "answers with a picture of 640x0");
}

TEST_F(V4l2CaptureTest, says_that_the_bus_is_full) {
  ASSERT_TRUE(capture.open({}));
  camera->fail_next(VIDIOC_STREAMON, -ENOSPC);
  const auto started = capture.start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, CameraFault::NoBandwidth);
  EXPECT_THAT(started.error().way_out, HasSubstr("the USB bus has no bandwidth left"));
  EXPECT_EQ(camera->mapped, 0);
}

TEST_F(V4l2CaptureTest, lists_and_sets_controls_under_v4l2_cameras_names) {
  v4l2_queryctrl brightness{};
  brightness.id = V4L2_CID_BRIGHTNESS;
  brightness.type = V4L2_CTRL_TYPE_INTEGER;
  std::memcpy(brightness.name, "Brightness", 11);
  brightness.maximum = 255;
  brightness.step = 1;
  v4l2_queryctrl white{};
  white.id = V4L2_CID_AUTO_WHITE_BALANCE;
  white.type = V4L2_CTRL_TYPE_BOOLEAN;
  std::memcpy(white.name, "White Balance, Automatic", 25);
  v4l2_queryctrl page{};
  page.id = V4L2_CID_CAMERA_CLASS;
  page.type = V4L2_CTRL_TYPE_CTRL_CLASS;
  camera->controls = {brightness, white, page};
  camera->control_values[V4L2_CID_BRIGHTNESS] = 128;
  begin();

  const auto controls = capture.controls();

  ASSERT_EQ(controls.size(), 2U);
  EXPECT_EQ(controls[0].name, "brightness");
  EXPECT_EQ(controls[0].value, 128);
  EXPECT_EQ(controls[0].most, 255);
  EXPECT_EQ(controls[1].name, "white_balance_automatic");
  EXPECT_TRUE(controls[1].is_switch);
  EXPECT_TRUE(capture.set_control(controls[0], 7));
  EXPECT_EQ(camera->control_values[V4L2_CID_BRIGHTNESS], 7);
  camera->fail_next(VIDIOC_S_CTRL, -ERANGE);
  const Problem refused = capture.set_control(controls[0], 700).error();
  EXPECT_EQ(refused.code, CameraFault::OutOfRange);
  EXPECT_EQ(refused.value, "700");
  EXPECT_THAT(refused.text(), AllOf(HasSubstr("set brightness failed"), HasSubstr("out of the control's range")));
  capture.close();
  const Problem closed = capture.set_control(controls[0], 7).error();
  EXPECT_EQ(closed.code, CameraFault::NotOpen);
  EXPECT_EQ(closed.what, "is not open");
}

}  // namespace
}  // namespace nacelle::camera
