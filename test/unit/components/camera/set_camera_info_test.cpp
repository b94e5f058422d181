// SPDX-License-Identifier: Apache-2.0
// The service set_camera_info of a camera, from the request to the file and to the next camera_info.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "camera/component/calibration.hpp"
#include "camera/component/camera_component.hpp"
#include "camera/port/v4l2_capture.hpp"
#include "camera/protocol/camera_info_yaml.hpp"
#include "nacelle/base/files.hpp"
#include "scripted_camera.hpp"
#include "sensor_msgs/srv/set_camera_info.hpp"
#include "support/recording_host.hpp"

namespace nacelle::camera {
namespace {

namespace fs = std::filesystem;
using sensor_msgs::msg::CameraInfo;
using sensor_msgs::srv::SetCameraInfo;
using ::testing::HasSubstr;

CameraInfo calibration_of(double focal_px) {
  CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, -0.25, 1e-05, 1.0 / 3, -0.0};
  info.k = {focal_px, 0, 319.5, 0, focal_px, 239.5, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {focal_px, 0, 320, 0, 0, focal_px, 240, 0, 0, 0, 1, 0};
  return info;
}

/// Without root's right to write anywhere.
class AsAnyUser {
 public:
  AsAnyUser() {
    if (was_ == 0) { EXPECT_EQ(::seteuid(65534), 0); }
  }
  AsAnyUser(const AsAnyUser&) = delete;
  AsAnyUser& operator=(const AsAnyUser&) = delete;
  ~AsAnyUser() {
    if (was_ == 0) { EXPECT_EQ(::seteuid(0), 0); }
  }

 private:
  uid_t was_ = ::geteuid();
};

class SetCameraInfoTest : public ::testing::Test {
 public:
  SetCameraInfoTest() {
    std::string name = ::testing::TempDir() + "set_camera_info_XXXXXX";
    folder_ = ::mkdtemp(name.data());
    EXPECT_EQ(::chmod(folder_.c_str(), 0755), 0);
    path_ = folder_ / "front.yaml";
    std::ofstream{path_};  // empty: a calibration to come
    device->hold_time();
  }
  ~SetCameraInfoTest() override {
    ::chmod(folder_.c_str(), 0755);
    fs::remove_all(folder_);
  }
  std::unique_ptr<CameraComponent> make(const std::string& url) {
    auto options = NodeOptions{context}
                       .append_parameter_override("device_lost", std::string("wait"))
                       .append_parameter_override("camera_info_url", url);
    return std::make_unique<CameraComponent>(
        options, [this](Source, const Clock& c) { return std::make_unique<V4l2Capture>(c, device); });
  }
  std::unique_ptr<CameraComponent> active() {
    auto camera = make("file://" + path_.string());
    EXPECT_TRUE(camera->trigger(Transition::Configure).success);
    EXPECT_TRUE(camera->trigger(Transition::Activate).success);
    return camera;
  }
  /// Delivers a frame and returns its camera_info.
  CameraInfo next_info() {
    EXPECT_TRUE(device->deliver(sequence_++, 1));
    device->pass(0ms);
    const auto all = context.published<CameraInfo>("/camera/camera_info");
    return all.empty() ? CameraInfo{} : all.back();
  }
  SetCameraInfo::Response set(const CameraInfo& info) {
    SetCameraInfo::Request request;
    request.camera_info = info;
    SetCameraInfo::Response response;
    EXPECT_TRUE(context.call<SetCameraInfo>("/camera/set_camera_info", request, response));
    return response;
  }
  std::string content() { return read_regular_file(path_.string()).value(); }
  std::size_t file_count() {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator{folder_}, fs::directory_iterator{}));
  }

  test::RecordingContext context;
  std::shared_ptr<ScriptedCamera> device = std::make_shared<ScriptedCamera>(context.clock());
  fs::path folder_, path_;
  std::uint32_t sequence_ = 0;
};

TEST_F(SetCameraInfoTest, stores_the_calibration_and_publishes_it_with_the_next_frame) {
  ASSERT_EQ(::chmod(path_.c_str(), 0640), 0);
  const auto camera = active();
  EXPECT_EQ(next_info().k[0], 0) << "an empty file is no calibration";
  auto sent = calibration_of(500.5);
  sent.header.frame_id = "from_the_calibrator";

  const auto response = set(sent);

  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.status_message, "stored in " + path_.string());
  auto shown = next_info();
  EXPECT_EQ(shown.header.frame_id, "camera_optical_frame") << "the stream's own";
  shown.header = sent.header;
  EXPECT_EQ(shown, sent);
  EXPECT_EQ(fs::status(path_).permissions(), static_cast<fs::perms>(0640));
  EXPECT_EQ(file_count(), 1U) << "nothing is left beside it";
  const auto read = parse_camera_info(content(), "front.yaml");
  ASSERT_TRUE(read) << read.error().text();
  sent.header = {};
  EXPECT_EQ(read->info, sent);
  EXPECT_TRUE(std::signbit(read->info.d[4]));
}

TEST_F(SetCameraInfoTest, replaces_a_calibration_that_the_next_start_reads) {
  {
    const auto camera = active();
    ASSERT_TRUE(set(calibration_of(400)).success);
    ASSERT_TRUE(set(calibration_of(500)).success);
  }
  const auto camera = active();
  auto shown = next_info();
  shown.header = {};
  EXPECT_EQ(shown, calibration_of(500));
}

TEST_F(SetCameraInfoTest, is_not_answered_by_a_camera_that_is_not_active) {
  const auto camera = make("file://" + path_.string());
  ASSERT_TRUE(camera->trigger(Transition::Configure).success);
  SetCameraInfo::Request request;
  request.camera_info = calibration_of(500);
  SetCameraInfo::Response response;
  EXPECT_FALSE(context.call<SetCameraInfo>("/camera/set_camera_info", request, response));
  EXPECT_EQ(content(), "");
}

TEST_F(SetCameraInfoTest, is_used_again_when_the_device_is_opened_again) {
  const auto camera = active();
  ASSERT_TRUE(set(calibration_of(500)).success);
  ASSERT_TRUE(camera->trigger(Transition::Deactivate).success);
  ASSERT_TRUE(camera->trigger(Transition::Activate).success);
  EXPECT_EQ(next_info().k[0], 500);
}

TEST_F(SetCameraInfoTest, is_refused_while_the_device_has_never_been_there) {
  device->unplug();
  auto options = NodeOptions{context}
                     .append_parameter_override("device_lost", std::string("wait"))
                     .append_parameter_override("video_device", std::string("/dev/no-such-camera"))
                     .append_parameter_override("camera_info_url", "file://" + path_.string());
  CameraComponent camera{options, [this](Source, const Clock& c) { return std::make_unique<V4l2Capture>(c, device); }};
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  const auto response = set(calibration_of(500));
  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.status_message, HasSubstr("/dev/no-such-camera: was not opened yet"));
  EXPECT_EQ(content(), "");
}

TEST_F(SetCameraInfoTest, is_refused_with_the_way_out_if_no_file_is_named) {
  const auto camera = make("");
  ASSERT_TRUE(camera->trigger(Transition::Configure).success);
  ASSERT_TRUE(camera->trigger(Transition::Activate).success);
  const auto response = set(calibration_of(500));
  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.status_message, HasSubstr("parameter camera_info_url: is empty, so there is no file"));
  EXPECT_THAT(response.status_message, HasSubstr("file:///var/lib/nacelle/"));
}

TEST_F(SetCameraInfoTest, leaves_file_and_stream_as_they_were_if_the_message_is_no_calibration_of_these_images) {
  const auto camera = active();
  ASSERT_TRUE(set(calibration_of(400)).success);
  const std::string before = content();
  auto other_size = calibration_of(500);
  other_size.width = 1280;

  const auto response = set(other_size);

  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.status_message, HasSubstr("1280x480 pixels, the images have 640x480"));
  EXPECT_FALSE(set(CameraInfo{}).success);
  EXPECT_EQ(content(), before);
  EXPECT_EQ(next_info().k[0], 400);
}

TEST_F(SetCameraInfoTest, leaves_file_and_stream_as_they_were_if_the_folder_is_read_only) {
  const auto camera = active();
  ASSERT_TRUE(set(calibration_of(400)).success);
  const std::string before = content();
  ASSERT_EQ(::chmod(path_.c_str(), 0666), 0);
  ASSERT_EQ(::chmod(folder_.c_str(), 0555), 0);
  SetCameraInfo::Response response;
  {
    const AsAnyUser user;
    response = set(calibration_of(500));
  }
  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.status_message, HasSubstr(path_.string() + ": cannot be written: Permission denied"));
  EXPECT_THAT(response.status_message, HasSubstr("StateDirectory=nacelle"));
  EXPECT_EQ(content(), before);
  EXPECT_EQ(file_count(), 1U);
  EXPECT_EQ(next_info().k[0], 400);
}

TEST_F(SetCameraInfoTest, leaves_the_stream_as_it_was_if_the_disk_is_full) {
  const auto camera = active();
  ASSERT_TRUE(set(calibration_of(400)).success);
  fs::remove(path_);
  fs::create_symlink("/dev/full", path_);
  const auto response = set(calibration_of(500));
  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.status_message, HasSubstr("No space left on device"));
  EXPECT_EQ(next_info().k[0], 400);
}

}  // namespace
}  // namespace nacelle::camera
