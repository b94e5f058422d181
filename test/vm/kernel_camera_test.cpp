// SPDX-License-Identifier: Apache-2.0
// The camera component on the kernel's virtual camera: what it publishes, and what it does when the camera goes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "camera/component/camera_component.hpp"
#include "camera/port/v4l2_capture.hpp"
#include "support/recording_host.hpp"
#include "unit/components/camera/jpeg_picture.hpp"
#include "unit/components/camera/pooled_writer.hpp"
#include "vivid.hpp"

namespace nacelle::camera {
namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::CompressedImage;
using sensor_msgs::msg::Image;
using test::kPatience;
using test::Vivid;

class KernelCamera : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("camera");
    Vivid::calm();
    options_.append_parameter_override("video_device", Vivid::kCamera);
    options_.append_parameter_override("image_size", std::vector<std::int64_t>{320, 180});
    options_.append_parameter_override("output_encoding", std::string{"yuyv"});
  }
  void bring_up(CameraComponent& camera) {
    const auto configured = camera.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    const auto activated = camera.trigger(Transition::Activate);
    ASSERT_TRUE(activated.success) << activated.reason;
  }
  [[nodiscard]] bool wait_for_images(std::size_t more) {
    return context_.wait_for(kImages, context_.published<Image>(kImages).size() + more, kPatience);
  }

  static constexpr const char* kImages = "/camera/image_raw";
  SystemClock clock_;
  test::RecordingContext context_{clock_};
  NodeOptions options_{context_};
};

TEST_F(KernelCamera, publishes_images_with_every_field_set) {
  CameraComponent camera{options_};
  bring_up(camera);
  ASSERT_TRUE(context_.wait_for(kImages, 20, kPatience));
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);

  const Image image = context_.published<Image>(kImages).back();
  EXPECT_EQ(image.width, 320U);
  EXPECT_EQ(image.step, 640U);
  EXPECT_EQ(image.data.size(), 640U * 180U);
  EXPECT_EQ(image.encoding, "yuyv");
  EXPECT_EQ(context_.published<CameraInfo>("/camera/camera_info").size(), context_.published<Image>(kImages).size());
  const CaptureLoopStats stats = camera.stats();
  EXPECT_EQ(stats.adopted + stats.copied, stats.published);
}

/// The capture loop with a topic whose reader gives images back, or keeps them.
class KernelCapture : public ::testing::TestWithParam<FrameMemory> {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("camera");
    Vivid::calm();
    CaptureLoop::Settings settings;
    settings.wish.width = 320;
    settings.wish.height = 180;
    settings.wish.memory = GetParam();
    settings.output = find_pixel_format(kYuyv);
    loop_.emplace(CaptureLoop::Surroundings{capture_, clock_, logger_, images_.publisher, infos_.publisher, {}},
                  settings);
    ASSERT_TRUE(loop_->open());
    ASSERT_TRUE(loop_->start());
  }
  void TearDown() override {
    for (Block* block : images_.writer->kept) drop_reference(*block);
    images_.writer->kept.clear();
  }
  void take(std::uint64_t frames) {
    const std::uint64_t wanted = loop_->stats().published + frames;
    while (loop_->stats().published < wanted)
      ASSERT_NE(loop_->turn(clock_.now() + kPatience), CaptureLoop::Turn::Outage);
  }

  SystemClock clock_;
  Logger logger_{"camera"};
  PooledTopic<Image> images_{8};
  PooledTopic<CameraInfo> infos_{8};
  V4l2Capture capture_{clock_};
  std::optional<CaptureLoop> loop_;
};

TEST_P(KernelCapture, copies_nothing_while_readers_give_images_back) {
  take(30);
  EXPECT_EQ(loop_->stats().adopted, 30U);
  EXPECT_EQ(loop_->stats().copied, 0U);
}

TEST_P(KernelCapture, copies_frames_and_loses_none_while_readers_hold_the_other_buffers) {
  for (int i = 0; i < 5; ++i) {
    images_.writer->keep_next = true;
    take(1);
  }
  take(20);
  EXPECT_EQ(loop_->stats().adopted, 3U);
  EXPECT_EQ(loop_->stats().copied, 22U);
  EXPECT_EQ(capture_.stats().starved, 0U);
}
INSTANTIATE_TEST_SUITE_P(Memory, KernelCapture, ::testing::Values(FrameMemory::Mapped, FrameMemory::Own),
                         [](const auto& test) { return test.param == FrameMemory::Mapped ? "mapped" : "own"; });

// v4l2loopback: a camera whose pictures a program writes.
TEST(LoopbackCamera, publishes_jpegs_as_they_were_sent_and_decodes_them_for_readers_of_the_image) {
  NACELLE_ONLY_IN_MACHINE("camera");
  const std::string device = "/dev/video9";
  const io::Descriptor sender{::open(device.c_str(), O_RDWR | O_CLOEXEC)};
  v4l2_format sent{};
  sent.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  sent.fmt.pix.width = 320;
  sent.fmt.pix.height = 240;
  sent.fmt.pix.pixelformat = V4L2_PIX_FMT_MJPEG;
  sent.fmt.pix.sizeimage = 320 * 240 * 3;
  ASSERT_EQ(::ioctl(sender.number(), VIDIOC_S_FMT, &sent), 0);
  const PatternScene scene{320, 240, kRgb24};
  Bytes rgb(scene.frame_bytes());
  const auto jpeg_of = [&](std::uint64_t number) {
    scene.render(number, rgb);
    return encode_jpeg(rgb, 320, 240);
  };
  std::vector<Bytes> pictures;
  const auto send = [&](std::uint64_t number) {
    const Bytes& jpeg = pictures.emplace_back(jpeg_of(number));
    return ::write(sender.number(), jpeg.data(), jpeg.size()) == static_cast<ssize_t>(jpeg.size());
  };
  ASSERT_TRUE(send(0));

  SystemClock clock;
  Logger logger{"camera"};
  PooledTopic<Image> images{8};
  PooledTopic<CameraInfo> infos{8};
  PooledTopic<CompressedImage> jpegs{8};
  V4l2Capture capture{clock};
  CaptureLoop::Settings settings;
  settings.wish = {.device = device, .pixel_format = kMjpeg, .width = 320, .height = 240};
  settings.output = find_pixel_format(kRgb24);
  CaptureLoop loop{{capture, clock, logger, images.publisher, infos.publisher, {}, nullptr, &jpegs.publisher},
                   settings};
  const auto opened = loop.open();
  ASSERT_TRUE(opened) << opened.error().text();
  const auto started = loop.start();
  ASSERT_TRUE(started) << started.error().text();
  std::size_t newest = 0, strange = 0, decoded_bytes = 0;
  jpegs.writer->on_message = [&](const CompressedImage& message) {
    // The whole buffer of the picture that was sent before the stream began comes; of the others, what was sent.
    if (newest == 0 && message.data.size() > pictures[0].size() &&
        std::equal(pictures[0].begin(), pictures[0].end(), message.data.begin()))
      return;
    const auto same = std::find_if(pictures.begin(), pictures.end(), [&](const Bytes& jpeg) {
      return std::equal(message.data.begin(), message.data.end(), jpeg.begin(), jpeg.end());
    });
    newest = static_cast<std::size_t>(same - pictures.begin());
    strange += same == pictures.end() ? 1 : 0;
  };
  images.writer->on_message = [&](const Image& message) { decoded_bytes += message.data.size(); };
  for (std::uint64_t number = 1; number <= 20; ++number) {
    images.writer->readers = number <= 10 ? 1 : 0;
    ASSERT_TRUE(send(number));
    // The one that was sent before the stream began may come first.
    do { ASSERT_EQ(loop.turn(clock.now() + kPatience), CaptureLoop::Turn::Frame); } while (newest < number);
    ASSERT_EQ(newest, number);
  }
  EXPECT_EQ(strange, 0U);
  EXPECT_GT(loop.stats().published, 0U);
  EXPECT_EQ(decoded_bytes, loop.stats().published * 320 * 240 * 3);
  EXPECT_GE(loop.stats().not_decoded, 9U);
  EXPECT_EQ(loop.stats().undecodable, 0U);
}

TEST_F(KernelCamera, has_the_drivers_controls_as_parameters) {
  CameraComponent camera{options_};
  bring_up(camera);
  EXPECT_EQ(camera.get_parameter("brightness").as_int(), 128);
  EXPECT_TRUE(camera.set_parameter(Parameter{"brightness", std::int64_t{7}}).successful);
  EXPECT_FALSE(camera.set_parameter(Parameter{"brightness", std::int64_t{256}}).successful);
  EXPECT_EQ(camera.get_parameter("brightness").as_int(), 7);
  ASSERT_TRUE(camera.set_parameter(Parameter{"brightness", std::int64_t{128}}).successful);
}

TEST_F(KernelCamera, goes_on_after_an_error_of_the_stream) {
  CameraComponent camera{options_};
  bring_up(camera);
  ASSERT_TRUE(wait_for_images(2));
  Vivid::press(Vivid::FatalError);
  while (camera.stats().returns == 0) ASSERT_TRUE(wait_for_images(1));
  EXPECT_EQ(camera.stats().outages, 1U);
  EXPECT_EQ(camera.stats().returns, 1U);
  EXPECT_TRUE(context_.open_faults().empty());
  EXPECT_TRUE(context_.faults().empty());
}

TEST_F(KernelCamera, every_unplugging_is_counted_and_nothing_leaks) {
  CameraComponent camera{options_};
  bring_up(camera);
  ASSERT_TRUE(wait_for_images(2));
  const auto files = test::count_entries("/proc/self/fd"), threads = test::count_entries("/proc/self/task");
  const auto count = static_cast<std::uint64_t>(test::cycles());
  for (std::uint64_t cycle = 1; cycle <= count; ++cycle) {
    Vivid::unbind();
    context_.wait_for_open_faults(1);
    ASSERT_EQ(context_.open_faults().size(), 1U) << "in cycle " << cycle;
    ASSERT_FALSE(std::filesystem::exists(Vivid::kCamera));
    Vivid::bind();
    ASSERT_TRUE(test::wait_for_node(Vivid::kCamera, clock_));
    ASSERT_TRUE(wait_for_images(2)) << "in cycle " << cycle;
    EXPECT_TRUE(context_.open_faults().empty()) << "in cycle " << cycle;
  }
  EXPECT_EQ(test::count_entries("/proc/self/fd"), files);
  EXPECT_EQ(test::count_entries("/proc/self/task"), threads);
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
  EXPECT_EQ(camera.stats().outages, count);
  EXPECT_EQ(camera.stats().returns, count);
  EXPECT_TRUE(context_.faults().empty());
}

}  // namespace
}  // namespace nacelle::camera
