// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/ekf_options.hpp"

#include <gtest/gtest.h>

#include "ekf/component/ekf_component.hpp"
#include "ekf_cases.hpp"
#include "support/recording_host.hpp"

namespace nacelle::ekf {
namespace {

class EkfParameters : public ::testing::Test {
 protected:
  EkfOptions read() {
    Node node{"ekf", options_};
    declare_ekf_parameters(node);
    auto read = read_ekf_parameters(node);
    EXPECT_TRUE(read) << (read ? "" : read.error().text());
    return read ? *read : EkfOptions{};
  }
  std::string refusal() {
    Node node{"ekf", options_};
    declare_ekf_parameters(node);
    const auto read = read_ekf_parameters(node);
    EXPECT_FALSE(read);
    return read ? "" : read.error().text();
  }
  test::RecordingContext context_;
  NodeOptions options_{context_};
};

TEST_F(EkfParameters, without_any_input_the_planar_preset_holds) {
  const auto o = read();
  ASSERT_EQ(o.inputs.size(), 2U);
  EXPECT_EQ(o.inputs[0].topic, "odom");
  EXPECT_EQ(o.inputs[0].config, mask_of(kVx) | mask_of(kVy));
  EXPECT_EQ(o.inputs[1].topic, "imu/data_raw");
  EXPECT_EQ(o.inputs[1].config, mask_of(kVyaw));
  EXPECT_FALSE(o.filter.two_d_mode) << "as robot_localization";
  EXPECT_EQ(o.world_frame, "odom");
  EXPECT_EQ(o.tf_child(), "base_link");
  EXPECT_TRUE(o.notes.empty());
}

TEST_F(EkfParameters, one_named_input_ends_the_preset) {
  options_.append_parameter_override("odom0", std::string{"wheels"});
  options_.append_parameter_override("odom0_config", config_of({kX, kY, kYaw}));
  options_.append_parameter_override("odom1", std::string{"visual"});
  options_.append_parameter_override("odom1_config", config_of({kVx}));
  options_.append_parameter_override("pose0", std::string{"gps"});
  options_.append_parameter_override("pose0_config", config_of({kX}));
  options_.append_parameter_override("pose0_rejection_threshold", 3.0);
  const auto o = read();
  ASSERT_EQ(o.inputs.size(), 3U);
  EXPECT_EQ(o.inputs[1].topic, "visual");
  EXPECT_EQ(o.inputs[2].kind, InputKind::Pose);
  EXPECT_EQ(o.inputs[2].pose_gate, 3.0);
}

TEST_F(EkfParameters, an_unset_sensor_timeout_is_one_period) {
  options_.append_parameter_override("frequency", 50.0);
  EXPECT_EQ(read().filter.sensor_timeout, 20ms);
  options_.append_parameter_override("sensor_timeout", 0.1);
  EXPECT_EQ(read().filter.sensor_timeout, 100ms);
}

TEST_F(EkfParameters, a_map_filter_broadcasts_map_to_odom) {
  options_.append_parameter_override("world_frame", std::string{"map"});
  EXPECT_EQ(read().tf_parent(), "map");
  EXPECT_EQ(read().tf_child(), "odom");
}

TEST_F(EkfParameters, thirty_six_numbers_are_taken_with_a_note) {
  std::vector<double> numbers(36, 0.0);
  for (std::size_t i = 0; i < 6; ++i) numbers[i * 7] = 0.5;
  options_.append_parameter_override("process_noise_covariance", numbers);
  const auto o = read();
  ASSERT_EQ(o.notes.size(), 1U);
  EXPECT_NE(o.notes[0].find("process_noise_covariance"), std::string::npos);
  EXPECT_EQ(o.filter.process_noise.rate(kX, kX), 0.5);
  EXPECT_EQ(o.filter.process_noise.rate(kVx, kVx), 0.025);
}

TEST_F(EkfParameters, another_count_of_numbers_is_refused_with_the_three_that_are_right) {
  options_.append_parameter_override("initial_estimate_covariance", std::vector<double>(14, 1.0));
  const auto text = refusal();
  for (const char* word : {"initial_estimate_covariance", "14", "15", "225", "36"})
    EXPECT_NE(text.find(word), std::string::npos) << text;
}

TEST_F(EkfParameters, a_gap_in_the_numbering_is_found) {
  options_.append_parameter_override("odom1", std::string{"wheels"});
  EXPECT_NE(refusal().find("odom1"), std::string::npos);
}

TEST_F(EkfParameters, fourteen_booleans_are_refused) {
  options_.append_parameter_override("imu0", std::string{"imu"});
  options_.append_parameter_override("imu0_config", std::vector<bool>(14, true));
  EXPECT_NE(refusal().find("14 booleans"), std::string::npos);
}

TEST_F(EkfParameters, the_history_has_robot_localizations_names_and_its_absolute_length) {
  EXPECT_FALSE(read().filter.history.has_value());
  options_.append_parameter_override("history_length", -1.5);
  EXPECT_FALSE(read().filter.history.has_value()) << "without smooth_lagged_data";
  options_.append_parameter_override("smooth_lagged_data", true);
  options_.append_parameter_override("permit_corrected_publication", true);
  const auto o = read();
  EXPECT_EQ(o.filter.history, 1500ms);
  EXPECT_TRUE(o.filter.permit_corrected_publication);
}

TEST_F(EkfParameters, a_history_of_more_than_an_hour_is_refused) {
  options_.append_parameter_override("smooth_lagged_data", true);
  options_.append_parameter_override("history_length", 5000.0);
  EXPECT_NE(refusal().find("0 to 3600"), std::string::npos);
}

TEST_F(EkfParameters, time_jumps_reset_the_filter_in_simulated_time_only) {
  options_.append_parameter_override("reset_on_time_jump", true);
  EXPECT_FALSE(read().filter.reset_on_time_jump);
  options_.append_parameter_override("use_sim_time", true);
  EXPECT_TRUE(read().filter.reset_on_time_jump);
}

TEST_F(EkfParameters, a_copied_robot_localization_file_with_defaults_is_accepted) {
  for (const char* name : {"smooth_lagged_data", "use_control", "debug", "reset_on_time_jump"})
    options_.append_parameter_override(name, false);
  options_.append_parameter_override("history_length", 0.0);
  options_.append_parameter_override("transform_timeout", 0.0);
  options_.append_parameter_override("control_config", std::vector<bool>(6, false));
  options_.append_parameter_override("acceleration_limits", std::vector<double>(6, 1.0));
  read();
}

TEST_F(EkfParameters, robot_localizations_stock_control_is_taken_as_it_stands) {
  options_.append_parameter_override("use_control", true);
  options_.append_parameter_override("stamped_control", false);
  options_.append_parameter_override("control_timeout", 0.2);
  options_.append_parameter_override("control_config", std::vector<bool>{true, false, false, false, false, true});
  options_.append_parameter_override("acceleration_limits", std::vector<double>{1.3, 0.0, 0.0, 0.0, 0.0, 3.4});
  options_.append_parameter_override("deceleration_limits", std::vector<double>{1.3, 0.0, 0.0, 0.0, 0.0, 4.5});
  options_.append_parameter_override("acceleration_gains", std::vector<double>{0.8, 0.0, 0.0, 0.0, 0.0, 0.9});
  const auto o = read();
  EXPECT_TRUE(o.filter.control.controlled[0]);
  EXPECT_TRUE(o.filter.control.controlled[5]);
  EXPECT_FALSE(o.filter.control.controlled[1]);
  EXPECT_EQ(o.filter.control.timeout, 200ms);
  EXPECT_EQ(o.filter.control.acceleration_limits[5], 3.4);
  EXPECT_EQ(o.filter.control.deceleration_limits[5], 4.5);
  EXPECT_EQ(o.filter.control.deceleration_gains[5], 0.9) << "as the acceleration's unless set";
  EXPECT_TRUE(o.notes.empty());
}

TEST_F(EkfParameters, a_command_for_what_an_imu_measures_is_left_out_with_a_note) {
  options_.append_parameter_override("use_control", true);
  options_.append_parameter_override("control_timeout", 0.2);
  options_.append_parameter_override("control_config", std::vector<bool>{true, false, false, false, false, true});
  options_.append_parameter_override("imu0", std::string{"imu"});
  options_.append_parameter_override("imu0_config", config_of({kVyaw, kAx}));
  const auto o = read();
  EXPECT_FALSE(o.filter.control.controlled[0]);
  EXPECT_TRUE(o.filter.control.controlled[5]);
  ASSERT_EQ(o.notes.size(), 1U);
  EXPECT_NE(o.notes[0].find("imu0 measures ax"), std::string::npos) << o.notes[0];
}

TEST_F(EkfParameters, control_for_nothing_is_a_note_and_five_axes_are_refused) {
  options_.append_parameter_override("use_control", true);
  EXPECT_EQ(read().notes.size(), 1U);
  options_.append_parameter_override("acceleration_limits", std::vector<double>(5, 1.0));
  EXPECT_NE(refusal().find("acceleration_limits: has 5 numbers"), std::string::npos) << refusal();
}

TEST_F(EkfParameters, tf_prefix_stands_before_every_frame_with_a_slash) {
  options_.append_parameter_override("tf_prefix", std::string{"/robot1"});
  options_.append_parameter_override("base_link_frame", std::string{"/base"});
  const auto o = read();
  EXPECT_EQ(o.odom_frame, "robot1/odom");
  EXPECT_EQ(o.map_frame, "robot1/map");
  EXPECT_EQ(o.world_frame, "robot1/odom");
  EXPECT_EQ(o.base_link_frame, "robot1/base");
  EXPECT_EQ(o.base_link_frame_output, "robot1/base");
}

TEST_F(EkfParameters, base_link_frame_output_names_the_child_of_the_estimate) {
  options_.append_parameter_override("base_link_frame_output", std::string{"base_footprint"});
  EXPECT_EQ(read().base_link_frame, "base_link");
  EXPECT_EQ(read().tf_child(), "base_footprint");
  options_.append_parameter_override("base_link_frame_output", std::string{"map"});
  EXPECT_NE(refusal().find("base_link_frame_output"), std::string::npos) << refusal();
}

TEST_F(EkfParameters, an_input_of_what_two_d_mode_holds_is_a_note) {
  options_.append_parameter_override("two_d_mode", true);
  options_.append_parameter_override("pose0", std::string{"height"});
  options_.append_parameter_override("pose0_config", config_of({kZ}));
  const auto o = read();
  ASSERT_EQ(o.notes.size(), 1U);
  EXPECT_NE(o.notes[0].find("pose0_config"), std::string::npos) << o.notes[0];
}

TEST_F(EkfParameters, frequencies_frames_and_states_are_checked) {
  options_.append_parameter_override("frequency", 0.0);
  EXPECT_NE(refusal().find("frequency"), std::string::npos);
  options_.append_parameter_override("frequency", 30.0);
  options_.append_parameter_override("world_frame", std::string{"moon"});
  EXPECT_NE(refusal().find("moon"), std::string::npos);
  options_.append_parameter_override("world_frame", std::string{"odom"});
  options_.append_parameter_override("initial_state", std::vector<double>(3, 0.0));
  EXPECT_NE(refusal().find("initial_state"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::ekf
