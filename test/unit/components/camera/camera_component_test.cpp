// SPDX-License-Identifier: Apache-2.0
#include "camera/component/camera_component.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "camera/component/calibration.hpp"
#include "camera/port/camera_fault.hpp"
#include "camera/port/pattern_source.hpp"
#include "camera/port/v4l2_capture.hpp"
#include "camera/protocol/calibration_fault.hpp"
#include "nacelle/base/file_fault.hpp"
#include "scripted_camera.hpp"
#include "support/recording_host.hpp"

namespace nacelle::camera {
namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;
using ::testing::HasSubstr;

struct BadOption {
  const char* name;
  ParameterValue value;
  const char* says;
};
class BadOptions : public ::testing::TestWithParam<BadOption> {};
TEST_P(BadOptions, refuse_the_configuration_with_name_value_and_way_out) {
  test::RecordingContext context;
  CameraComponent camera{NodeOptions{context}.append_parameter_override(GetParam().name, GetParam().value)};
  const auto outcome = camera.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_EQ(outcome.state, StateId::Unconfigured);
  EXPECT_THAT(outcome.reason, HasSubstr(GetParam().name));
  EXPECT_THAT(outcome.reason, HasSubstr(GetParam().says));
}
INSTANTIATE_TEST_SUITE_P(
    All, BadOptions,
    ::testing::Values(BadOption{"pixel_format", std::string("YUYW"), "did you mean 'YUYV'"},
                      BadOption{"output_encoding", std::string("rgb"), "did you mean 'rgb8'"},
                      BadOption{"image_size", std::vector<std::int64_t>{640}, "[640] is not a size"},
                      BadOption{"image_size", std::vector<std::int64_t>{-1, 480}, "[-1, 480] is not a size"},
                      BadOption{"time_per_frame", std::vector<std::int64_t>{1, 0}, "[1, 0] is not a time"},
                      BadOption{"video_device", std::string(), "is empty"},
                      BadOption{"camera_frame_id", std::string(), "is empty"},
                      BadOption{"camera_info_url", std::string("package://robot/front.yaml"), "package index"},
                      BadOption{"camera_info_url", std::string("/etc/front.yaml"), "no URL"},
                      BadOption{"camera_info_url", std::string("file:///no/such/file.yaml"), "cannot be read"}));

TEST(CameraComponent, says_that_the_device_is_absent_when_it_is_required) {
  test::RecordingContext context;
  CameraComponent camera{NodeOptions{context}
                             .append_parameter_override("required_device", true)
                             .append_parameter_override("video_device", std::string("/dev/no-such-camera"))};
  const auto outcome = camera.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_THAT(outcome.reason, HasSubstr("/dev/no-such-camera: open failed: No such file or directory (errno 2)"));
  EXPECT_THAT(outcome.reason, HasSubstr("plugged in"));
}

// A port that finds no camera of libcamera, or cannot tell for lack of rights.
class AbsentCamera final : public CapturePort {
 public:
  explicit AbsentCamera(CameraFault fault) : fault_(fault) {}
  Result<CaptureFormat, Problem> open(const CaptureWish& wish) override {
    return err(Problem{wish.device, "libcamera sees no camera", "", fault_});
  }
  Result<void, Problem> start() override { return {}; }
  Result<Frame, CaptureFault> next(MonotonicTime, ByteSpan) override { return err(CaptureFault::NoFrame); }
  void interrupt() noexcept override {}
  void close() override {}
  std::vector<Control> controls() override { return {}; }
  Result<void, Problem> set_control(const Control&, std::int64_t) override { return {}; }
  CaptureStats stats() const override { return {}; }

 private:
  CameraFault fault_;
};

TEST(CameraComponent, waits_for_a_camera_of_libcamera_that_is_absent_and_for_no_other_reason) {
  for (const CameraFault fault : {CameraFault::NotThere, CameraFault::Busy, CameraFault::NotInstalled}) {
    test::RecordingContext context;
    std::vector<Source> made;
    CameraComponent camera{
        NodeOptions{context}.append_parameter_override("video_device", std::string("libcamera:imx219")),
        [&](Source source, const Clock&) {
          made.push_back(source);
          return std::make_unique<AbsentCamera>(fault);
        }};
    const auto outcome = camera.trigger(Transition::Configure);
    EXPECT_EQ(made, std::vector<Source>{Source::Libcamera});
    EXPECT_EQ(outcome.success, fault == CameraFault::NotThere) << code_text(fault);
    if (!outcome.success) { EXPECT_THAT(outcome.reason, HasSubstr("libcamera:imx219: libcamera sees no camera")); }
    EXPECT_EQ(context.open_faults().size(), outcome.success ? 1U : 0U);
  }
}

TEST(CameraComponent, opens_a_fault_and_shows_no_pattern_when_the_device_is_absent) {
  test::RecordingContext context;
  CameraComponent camera{
      NodeOptions{context}.append_parameter_override("video_device", std::string("/dev/no-such-camera"))};
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  ASSERT_EQ(context.open_faults().size(), 1U);
  EXPECT_EQ(context.open_faults()[0].code, kDeviceLost);
  EXPECT_THAT(context.open_faults()[0].text, HasSubstr("/dev/no-such-camera"));
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
  EXPECT_TRUE(context.published<Image>("/camera/image_raw").empty());
}

TEST(CameraComponent, shows_the_pattern_on_its_thread) {
  const SystemClock clock;
  test::RecordingContext context{clock};
  CameraComponent camera{NodeOptions{context}.append_parameter_override("video_device", std::string("pattern"))};
  for (int round = 1; round <= 2; ++round) {  // up and down twice
    ASSERT_TRUE(camera.trigger(Transition::Configure).success);
    ASSERT_TRUE(camera.trigger(Transition::Activate).success);
    EXPECT_TRUE(context.wait_for("/camera/image_raw", static_cast<std::size_t>(4 * round)));
    EXPECT_TRUE(camera.trigger(Transition::Deactivate).success);
    EXPECT_TRUE(camera.trigger(Transition::Cleanup).success);
  }
  const auto images = context.published<Image>("/camera/image_raw");
  const auto infos = context.published<CameraInfo>("/camera/camera_info");
  ASSERT_GE(images.size(), 8U);
  ASSERT_GE(infos.size(), images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    ASSERT_EQ(images[i].encoding, "rgb8");
    ASSERT_EQ(images[i].data.size(), 640U * 480U * 3U);
    ASSERT_EQ(images[i].header, infos[i].header);
    ASSERT_EQ(infos[i].distortion_model, "plumb_bob");
    ASSERT_NEAR(infos[i].k[0], 554.256, 0.001);
  }
  EXPECT_EQ(images[0].header.frame_id, "camera_optical_frame");
  EXPECT_TRUE(context.faults().empty());
}

TEST(CameraComponent, can_be_activated_again_after_a_deactivation_and_shut_down_from_any_state) {
  const SystemClock clock;
  test::RecordingContext context{clock};
  CameraComponent camera{NodeOptions{context}.append_parameter_override("video_device", std::string("pattern"))};
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(camera.trigger(Transition::Activate).success);
    ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
  }
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  EXPECT_TRUE(camera.trigger(Transition::Shutdown).success);
}

class ScriptedCameraTest : public ::testing::Test {
 public:
  CameraComponent make(const NodeOptions& options) {
    return CameraComponent{options,
                           [this](Source, const Clock& c) { return std::make_unique<V4l2Capture>(c, device); }};
  }
  test::RecordingContext context;
  std::shared_ptr<ScriptedCamera> device = std::make_shared<ScriptedCamera>(context.clock());
};

class CameraControls : public ScriptedCameraTest {
 public:
  CameraControls() {
    v4l2_queryctrl brightness{};
    brightness.id = V4L2_CID_BRIGHTNESS;
    brightness.type = V4L2_CTRL_TYPE_INTEGER;
    std::memcpy(brightness.name, "Brightness", 11);
    brightness.maximum = 255;
    device->controls = {brightness};
    device->control_values[V4L2_CID_BRIGHTNESS] = 128;
  }
};

TEST_F(CameraControls, are_parameters_while_the_device_is_open) {
  auto camera = make(NodeOptions{context});
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  EXPECT_EQ(camera.get<std::int64_t>("brightness"), 128);
  EXPECT_TRUE(camera.set_parameter({"brightness", std::int64_t{7}}).successful);
  EXPECT_EQ(device->control_values[V4L2_CID_BRIGHTNESS], 7);
  device->fail_next(VIDIOC_S_CTRL, -ERANGE);
  const auto refused = camera.set_parameter({"brightness", std::int64_t{7000}});
  EXPECT_FALSE(refused.successful);
  EXPECT_THAT(refused.reason, HasSubstr("range"));
  ASSERT_TRUE(camera.trigger(Transition::Cleanup).success);
  EXPECT_FALSE(camera.has_parameter("brightness"));
}

TEST_F(CameraControls, are_set_from_the_launch_file_and_again_when_the_device_is_opened_again) {
  auto camera = make(NodeOptions{context}
                         .append_parameter_override("brightness", std::int64_t{200})
                         .append_parameter_override("contrast", std::int64_t{5}));
  ASSERT_TRUE(camera.trigger(Transition::Configure).success) << "a control that is missing costs a warning";
  EXPECT_EQ(device->control_values[V4L2_CID_BRIGHTNESS], 200);
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
  device->control_values[V4L2_CID_BRIGHTNESS] = 1;  // another program used it meanwhile
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  EXPECT_EQ(device->control_values[V4L2_CID_BRIGHTNESS], 200);
}

TEST_F(CameraControls, are_set_by_the_activation_that_follows_a_loss) {
  auto camera = make(NodeOptions{context}.append_parameter_override("brightness", std::int64_t{200}));
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  device->unplug();
  while (camera.stats().outages == 0) context.clock().advance(10ms);
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
  device->plug();
  device->control_values[V4L2_CID_BRIGHTNESS] = 1;
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  EXPECT_EQ(device->control_values[V4L2_CID_BRIGHTNESS], 200)
      << "the activation opens the device, not its thread later";
}

TEST_F(CameraControls, a_lost_device_is_a_fault_after_two_seconds_where_that_is_asked_for) {
  auto camera = make(NodeOptions{context}.append_parameter_override("device_lost", std::string("fault")));
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  device->unplug();
  while (context.faults().empty()) context.clock().advance(10ms);
  EXPECT_EQ(context.faults()[0].code, "CAMERA_SILENT");
  EXPECT_TRUE(context.open_faults().empty());
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
}

TEST_F(CameraControls, of_a_device_that_comes_after_the_bring_up_are_parameters_then_and_its_open_fault_is_over) {
  device->unplug();
  auto camera = make(NodeOptions{context}
                         .append_parameter_override("video_device", std::string("/dev/no-such-camera"))
                         .append_parameter_override("brightness", std::int64_t{200}));
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  ASSERT_EQ(context.open_faults().size(), 1U);
  EXPECT_EQ(context.open_faults()[0].code, kDeviceLost);

  device->plug();
  while (camera.stats().returns == 0) context.clock().advance(10ms);
  // The clock advances while the driver waits for a frame, so the driver loses the device again as soon as a frame is missing. A
  // driver that ran out of buffers reopens the device after a pause. Therefore deliver frames and advance the clock until the fault
  // has been closed once, and the control is set: at once, or when a device that was lost meanwhile is open again.
  for (std::uint32_t frame = 0; context.closed_faults() == 0 || device->control_value(V4L2_CID_BRIGHTNESS) != 200;
       ++frame) {
    device->deliver(frame, 1);
    context.advance(1ms);
  }
  EXPECT_EQ(camera.get_current_state().state(), StateId::Active);
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
}

// With device_lost: wait. While the camera is open, time passes only where a test lets it.
class ActiveCamera : public ScriptedCameraTest {
 public:
  ActiveCamera() { device->hold_time(); }
  NodeOptions options() { return NodeOptions{context}.append_parameter_override("device_lost", std::string("wait")); }
  void activate(CameraComponent& camera) {
    ASSERT_TRUE(camera.trigger(Transition::Configure).success);
    ASSERT_TRUE(camera.trigger(Transition::Activate).success);
    deliver();
    ASSERT_EQ(images(), 1U);
  }
  /// Delivers one frame and returns when the driver has handled it.
  void deliver() {
    ASSERT_TRUE(device->deliver(sequence++, 1));
    device->pass(0ms);
  }
  /// Tells time until the driver streams again, then delivers one frame.
  void deliver_after_reopening() {
    while (!device->deliver(sequence, 1)) {
      context.advance(1ms);
      std::this_thread::yield();  // to the driver, which needs the scripted camera's lock
    }
    ++sequence;
    device->pass(0ms);
  }
  /// Returns when the driver has closed the device that it lost.
  static void wait_for_outage(const CameraComponent& camera) {
    while (camera.stats().outages == 0) std::this_thread::yield();
  }
  std::size_t images() { return context.published<Image>("/camera/image_raw").size(); }
  void expect_lost(const CameraComponent& camera, const char* why) {
    ASSERT_EQ(context.open_faults().size(), 1U);
    EXPECT_EQ(context.open_faults()[0].code, kDeviceLost);
    EXPECT_THAT(context.open_faults()[0].text, HasSubstr(why));
    EXPECT_EQ(context.closed_faults(), 0U);
    EXPECT_TRUE(context.faults().empty()) << "nothing to apply on_fault to";
    EXPECT_EQ(camera.get_current_state().state(), StateId::Active);
  }
  void expect_back(const CameraComponent& camera, std::size_t frames) {
    EXPECT_TRUE(context.open_faults().empty());
    EXPECT_EQ(context.closed_faults(), 1U);
    EXPECT_EQ(images(), frames);
    EXPECT_TRUE(context.faults().empty());
    EXPECT_EQ(camera.get_current_state().state(), StateId::Active);
  }
  std::uint32_t sequence = 0;
};

TEST_F(ActiveCamera, reports_silence_within_half_a_second_and_closes_the_fault_with_the_next_frame) {
  auto camera = make(options());
  ASSERT_NO_FATAL_FAILURE(activate(camera));

  device->pass(400ms);
  EXPECT_TRUE(context.open_faults().empty());
  device->pass(100ms);
  expect_lost(camera, "/dev/video0: silent for 0.5 s (1 frames so far)");

  deliver();
  expect_back(camera, 2);
  EXPECT_EQ(camera.stats().outages, 0U) << "the stream never broke";
}

TEST_F(ActiveCamera, may_be_silent_for_three_frame_periods_where_these_are_longer) {
  device->frame_time = {1, 1};
  auto camera = make(options().append_parameter_override("time_per_frame", std::vector<std::int64_t>{1, 1}));
  ASSERT_NO_FATAL_FAILURE(activate(camera));
  for (int second = 0; second < 5; ++second) {
    device->pass(1s);
    EXPECT_TRUE(context.open_faults().empty()) << "second " << second;
    deliver();
  }
  EXPECT_EQ(context.closed_faults(), 0U);
  EXPECT_EQ(camera.stats().outages, 0U) << "the port does not take it for broken, either";

  device->pass(2900ms);
  EXPECT_TRUE(context.open_faults().empty());
  device->pass(100ms);
  expect_lost(camera, "/dev/video0: silent for 3.0 s (6 frames so far)");

  deliver();
  expect_back(camera, 7);
}

TEST_F(ActiveCamera, reports_at_once_that_it_was_unplugged_and_delivers_again_when_it_is_plugged_in) {
  auto camera = make(options());
  ASSERT_NO_FATAL_FAILURE(activate(camera));

  device->unplug();
  wait_for_outage(camera);
  ASSERT_NO_FATAL_FAILURE(expect_lost(camera, "/dev/video0: the device is gone"));
  while (context.open_faults()[0].text.find("open failed") == std::string::npos) context.advance(1ms);
  expect_lost(camera, "/dev/video0: open failed: No such file or directory");

  device->plug();
  deliver_after_reopening();
  deliver();
  expect_back(camera, 3);
  EXPECT_EQ(camera.stats().outages, 1U);
  EXPECT_EQ(camera.stats().returns, 1U);
}

TEST_F(ActiveCamera, reports_a_failed_read_and_starts_the_stream_again) {
  auto camera = make(options());
  ASSERT_NO_FATAL_FAILURE(activate(camera));

  device->fail_next(VIDIOC_DQBUF, -EIO);
  ASSERT_TRUE(device->deliver(sequence++, 1));
  wait_for_outage(camera);
  expect_lost(camera, "/dev/video0: the driver lost the stream");

  deliver_after_reopening();
  deliver();
  expect_back(camera, 3);
  EXPECT_EQ(camera.stats().outages, 1U);
  EXPECT_EQ(camera.stats().returns, 1U);
}

TEST(CalibrationPath, replaces_the_names_that_camera_info_manager_knows) {
  ::setenv("ROS_HOME", "/var/ros", 1);
  EXPECT_EQ(calibration_path("file://${ROS_HOME}/camera_info/${NAME}.yaml", "hd_webcam").value(),
            "/var/ros/camera_info/hd_webcam.yaml");
  EXPECT_EQ(calibration_path("file:///etc/a.yaml", "x").value(), "/etc/a.yaml");
}

TEST(CalibrationPath, refuses_a_url_that_names_no_file) {
  for (const char* const url : {"file://etc/a.yaml", "/etc/a.yaml", "flash:///", "package://robot/front.yaml"}) {
    const auto path = calibration_path(url, "x");
    ASSERT_FALSE(path) << url;
    EXPECT_EQ(path.error().code, CalibrationFault::UnsupportedUrl) << url;
    EXPECT_EQ(path.error().where, Place::of_parameter("camera_info_url")) << url;
    EXPECT_EQ(path.error().value, url);
  }
}

TEST(Calibration, that_cannot_be_read_is_a_fault_of_the_file) {
  const auto checked = check_calibration("file:///no/such/file.yaml");
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().code, FileFault::NotFound);
  EXPECT_EQ(checked.error().where, Place::of_parameter("camera_info_url"));
  EXPECT_EQ(checked.error().value, "/no/such/file.yaml");
}

TEST(StreamInfo, uses_a_calibration_of_the_images_size_only) {
  const auto path = std::filesystem::path{::testing::TempDir()} / "camera_component_test_front.yaml";
  std::ofstream{path} << "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, "
                         "0, 500, 240, 0, 0, 1]}\n"
                         "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"
                         "rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"
                         "projection_matrix: {rows: 3, cols: 4, data: [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]}\n";
  CaptureFormat format;
  format.width = 640;
  format.height = 480;
  const auto fitting = stream_info("file://" + path.string(), format);
  ASSERT_TRUE(fitting) << fitting.error().text();
  EXPECT_EQ(fitting.value().info.k[0], 500);
  EXPECT_TRUE(fitting.value().remark.empty());

  format.width = 320;
  const auto other = stream_info("file://" + path.string(), format);
  ASSERT_TRUE(other);
  EXPECT_EQ(other.value().info.k[0], 0);
  EXPECT_EQ(other.value().info.width, 320U);
  EXPECT_THAT(other.value().remark, HasSubstr("640x480"));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace nacelle::camera
