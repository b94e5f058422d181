// SPDX-License-Identifier: Apache-2.0
#include "detector/component/detector_component.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "camera/model/pattern_scene.hpp"
#include "support/recording_host.hpp"

namespace nacelle::detector {
namespace {

using geometry_msgs::msg::PoseArray;
using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;

class DetectorComponentTest : public ::testing::Test {
 protected:
  void SetUp() override {
    image.width = 640;
    image.height = 480;
    image.step = scene.bytes_per_line();
    image.encoding = "rgb8";
    image.data.resize(scene.frame_bytes());
    image.header.frame_id = "camera_optical_frame";
  }
  void show(std::uint64_t frame) {
    scene.render(frame, {image.data.data(), image.data.size()});
    image.header.stamp.sec = static_cast<std::int32_t>(frame);
    context.inject("/camera/image_raw", image);
  }
  static void start(DetectorComponent& detector) {
    ASSERT_TRUE(detector.trigger(Transition::Configure).success);
    ASSERT_TRUE(detector.trigger(Transition::Activate).success);
  }

  test::RecordingContext context;
  const camera::PatternScene scene{640, 480, camera::kRgb24};
  Image image;
};

TEST_F(DetectorComponentTest, tells_where_the_disc_of_the_cameras_pattern_is) {
  DetectorComponent detector{NodeOptions{context}};
  start(detector);
  std::vector<std::uint64_t> frames;
  for (std::uint64_t frame = 0; frame < 2100; frame += 13) frames.push_back(frame);
  for (const std::uint64_t frame : frames) show(frame);

  const auto answers = context.published<PoseArray>("/detections");

  ASSERT_EQ(answers.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "frame " << frames[i]);
    const auto truth = camera::PatternScene::disc_position(frames[i]);
    ASSERT_EQ(answers[i].poses.size(), 1U);
    const auto& position = answers[i].poses[0].position;
    ASSERT_NEAR(position.x, truth.x_m, 0.01);
    ASSERT_NEAR(position.y, truth.y_m, 0.01);
    ASSERT_NEAR(position.z, truth.z_m, 0.01 * truth.z_m);
    ASSERT_EQ(answers[i].poses[0].orientation.w, 1.0);
    ASSERT_EQ(answers[i].header.frame_id, "camera_optical_frame");
    ASSERT_EQ(answers[i].header.stamp.sec, static_cast<std::int32_t>(frames[i]));
  }
}

TEST_F(DetectorComponentTest, believes_a_calibration_of_the_images_size_and_no_other) {
  DetectorComponent detector{NodeOptions{context}};
  start(detector);
  CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.k = {2 * 554.256, 0, 319.5, 0, 2 * 554.256, 239.5, 0, 0, 1};
  context.inject("/camera/camera_info", info);
  show(0);
  info.width = 320;
  context.inject("/camera/camera_info", info);
  show(0);
  const auto answers = context.published<PoseArray>("/detections");
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_NEAR(answers[0].poses.at(0).position.z, 2 * answers[1].poses.at(0).position.z, 1e-3);
}

TEST_F(DetectorComponentTest, answers_every_image_also_without_a_disc) {
  DetectorComponent detector{NodeOptions{context}
                                 .append_parameter_override("hue_min", std::int64_t{100})
                                 .append_parameter_override("hue_max", std::int64_t{120})};
  start(detector);
  show(0);
  const auto answers = context.published<PoseArray>("/detections");
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_TRUE(answers[0].poses.empty());
}

TEST_F(DetectorComponentTest, counts_images_that_it_cannot_read) {
  DetectorComponent detector{NodeOptions{context}};
  start(detector);
  image.encoding = "16UC1";
  show(0);
  image.encoding = "rgb8";
  image.data.resize(100);
  context.inject("/camera/image_raw", image);
  EXPECT_EQ(detector.stats().images, 2U);
  EXPECT_EQ(detector.stats().refused, 2U);
  EXPECT_TRUE(context.published<PoseArray>("/detections").empty());
}

TEST_F(DetectorComponentTest, names_the_parameter_that_is_out_of_range) {
  try {
    DetectorComponent detector{NodeOptions{context}.append_parameter_override("decimation", std::int64_t{0})};
    FAIL() << "a decimation of 0 was accepted";
  } catch (const exceptions::InvalidParameterValueException& refusal) {
    EXPECT_THAT(refusal.what(), ::testing::HasSubstr("decimation"));
    EXPECT_THAT(refusal.what(), ::testing::HasSubstr("1 to 8"));
  }
  DetectorComponent detector{NodeOptions{context}.append_parameter_override("value_max", std::int64_t{10})};
  const auto outcome = detector.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_THAT(outcome.reason, ::testing::HasSubstr("80 is above value_max 10"));
}

}  // namespace
}  // namespace nacelle::detector
