// SPDX-License-Identifier: Apache-2.0
// CameraComponent with the port of nacelle/ports/libcamera.so, as a robot has it, on libcamera's own virtual pipeline.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "camera/component/camera_component.hpp"
#include "support/recording_host.hpp"
#include "virtual_cameras.hpp"

namespace nacelle::camera {
namespace {

using test::kPatience;

class LibcameraRobot : public ::testing::Test {
 protected:
  void SetUp() override { NACELLE_WITH_VIRTUAL_CAMERAS(); }
};

TEST_F(LibcameraRobot, publishes_images_in_colour_and_the_size_as_camera_info) {
  const SystemClock clock;
  test::RecordingContext context{clock};
  CameraComponent camera{NodeOptions{context}
                             .append_parameter_override("video_device", std::string("libcamera:Front"))
                             .append_parameter_override("image_size", std::vector<std::int64_t>{320, 240})};
  const auto configured = camera.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  std::size_t seen = 0;
  for (int round = 0; round < 2; ++round) {  // a deactivation lets the camera go
    ASSERT_TRUE(camera.trigger(Transition::Activate).success);
    ASSERT_TRUE(context.wait_for("/camera/image_raw", seen + 3, kPatience));
    ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
    seen = context.published<sensor_msgs::msg::Image>("/camera/image_raw").size();
  }
  const auto images = context.published<sensor_msgs::msg::Image>("/camera/image_raw");
  EXPECT_EQ(images[0].encoding, "rgb8");
  EXPECT_EQ(images[0].data.size(), 320U * 240U * 3U);
  const auto line = std::vector<std::uint8_t>(images[0].data.begin(), images[0].data.begin() + 3L * 320);
  EXPECT_GT(*std::max_element(line.begin(), line.end()), 180) << "bars of all colours";
  EXPECT_LT(*std::min_element(line.begin(), line.end()), 40);
  EXPECT_EQ(context.published<sensor_msgs::msg::CameraInfo>("/camera/camera_info")[0].width, 320U);
  EXPECT_TRUE(context.faults().empty());
  EXPECT_TRUE(context.open_faults().empty());
}

TEST_F(LibcameraRobot, waits_for_a_camera_that_is_absent) {
  const SystemClock clock;
  test::RecordingContext context{clock};
  CameraComponent camera{NodeOptions{context}.append_parameter_override("video_device", std::string("libcamera:Side"))};
  ASSERT_TRUE(camera.trigger(Transition::Configure).success);
  ASSERT_TRUE(camera.trigger(Transition::Activate).success);
  ASSERT_EQ(context.open_faults().size(), 1U);
  EXPECT_THAT(context.open_faults()[0].text, ::testing::HasSubstr("libcamera has no such camera"));
  ASSERT_TRUE(camera.trigger(Transition::Deactivate).success);
}

}  // namespace
}  // namespace nacelle::camera
