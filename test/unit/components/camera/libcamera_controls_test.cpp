// SPDX-License-Identifier: Apache-2.0
#include "camera/port/libcamera_controls.hpp"

#include <gtest/gtest.h>
#include <libcamera/control_ids.h>

#include <array>
#include <limits>

namespace nacelle::camera {
namespace {

namespace controls = ::libcamera::controls;
using ::libcamera::ControlInfo;
using ::libcamera::ControlInfoMap;
using ::libcamera::ControlValue;

ControlInfoMap pi_camera() {
  const std::array<std::int64_t, 2> least{33'333, 33'333}, most{100'000, 100'000};
  return {{{&controls::ExposureTime, ControlInfo{ControlValue{std::int32_t{100}}, ControlValue{std::int32_t{66'666}},
                                                 ControlValue{std::int32_t{20'000}}}},
           {&controls::AnalogueGain, ControlInfo{ControlValue{1.0F}, ControlValue{10.67F}}},
           {&controls::Brightness, ControlInfo{ControlValue{-1.0F}, ControlValue{1.0F}, ControlValue{0.0F}}},
           {&controls::ExposureValue,
            ControlInfo{ControlValue{-8.0F}, ControlValue{std::numeric_limits<float>::infinity()}, ControlValue{0.0F}}},
           {&controls::AeEnable, ControlInfo{ControlValue{false}, ControlValue{true}, ControlValue{true}}},
           {&controls::FrameDurationLimits, ControlInfo{ControlValue{::libcamera::Span<const std::int64_t, 2>{least}},
                                                        ControlValue{::libcamera::Span<const std::int64_t, 2>{most}}}}},
          controls::controls};
}

TEST(LibcameraControls, are_named_as_parameters_are) {
  EXPECT_EQ(control_parameter_name("ExposureTime"), "exposure_time");
  EXPECT_EQ(control_parameter_name("AeEnable"), "ae_enable");
  EXPECT_EQ(control_parameter_name("Sharpness"), "sharpness");
  EXPECT_EQ(control_parameter_name(""), "");
}

TEST(LibcameraControls, of_one_number_are_listed_by_name_with_their_ranges) {
  const ControlInfoMap map = pi_camera();
  const auto listed = list_controls(map);
  ASSERT_EQ(listed.size(), 5U) << "limits are two numbers";
  EXPECT_EQ(listed[0].name, "ae_enable");
  EXPECT_TRUE(listed[0].is_switch);
  EXPECT_EQ(listed[0].value, 1);
  EXPECT_EQ(listed[1].name, "analogue_gain_milli");
  EXPECT_EQ(listed[1].least, 1000);
  EXPECT_EQ(listed[1].most, 10'670);
  EXPECT_EQ(listed[1].value, 1000) << "without a default the least";
  EXPECT_EQ(listed[2].name, "brightness_milli");
  EXPECT_EQ(listed[2].least, -1000);
  EXPECT_EQ(listed[2].value, 0);
  EXPECT_EQ(listed[3].name, "exposure_time");
  EXPECT_EQ(listed[3].least, 100);
  EXPECT_EQ(listed[3].most, 66'666);
  EXPECT_EQ(listed[3].value, 20'000);
  EXPECT_EQ(listed[4].name, "exposure_value_milli");
  EXPECT_GT(listed[4].most, 1'000'000) << "no limit";
}

TEST(LibcameraControls, are_set_in_libcameras_own_type) {
  const ControlInfoMap map = pi_camera();
  EXPECT_EQ(control_value(map, controls::EXPOSURE_TIME, 5000), ControlValue{std::int32_t{5000}});
  EXPECT_EQ(control_value(map, controls::ANALOGUE_GAIN, 2500), ControlValue{2.5F});
  EXPECT_EQ(control_value(map, controls::BRIGHTNESS, -500), ControlValue{-0.5F});
  EXPECT_EQ(control_value(map, controls::AE_ENABLE, 0), ControlValue{false});
  EXPECT_FALSE(control_value(map, controls::CONTRAST, 1)) << "this camera has none";
}

}  // namespace
}  // namespace nacelle::camera
