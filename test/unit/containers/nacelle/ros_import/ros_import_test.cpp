// SPDX-License-Identifier: Apache-2.0
#include "ros_import/ros_import.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "ros_import/drivers.hpp"

namespace nacelle::ros_import {
namespace {

using testing::HasSubstr;
using testing::Not;

Imported imported(const std::string& text) {
  Imported result;
  const auto done = import_file(text, "old.yaml", result);
  EXPECT_TRUE(done) << (done ? "" : done.error().front().text());
  return result;
}

std::string note_of(const Imported& result, const std::string& key) {
  for (const auto& note : result.notes) {
    if (note.key == key) return note.line();
  }
  return "no note of " + key;
}

TEST(RosImport, gives_the_geometry_to_the_base_and_to_the_odometry) {
  const Imported result = imported(R"(
diff_drive_controller:
  ros__parameters: {wheel_radius: 0.033, wheel_separation: 0.3, odom_frame_id: odom, cmd_vel_timeout: 0.5}
)");
  EXPECT_EQ(result.yaml(), R"(diff_drive:
  ros__parameters:
    wheel_radius: 0.033
    wheel_separation: 0.3
    cmd_vel_timeout: 0.5

odometry:
  ros__parameters:
    wheel_radius: 0.033
    wheel_separation: 0.3
    odom_frame_id: odom
    velocity_rolling_window_size: 10
)");
}

TEST(RosImport, writes_what_the_driver_does_unless_it_is_told) {
  const Imported silent = imported("diff_drive_controller: {ros__parameters: {wheel_radius: 0.1}}");
  EXPECT_THAT(silent.yaml(), HasSubstr("velocity_rolling_window_size: 10"));
  EXPECT_THAT(note_of(silent, "velocity_rolling_window_size"), HasSubstr("added: "));

  const Imported told =
      imported("diff_drive_controller: {ros__parameters: {wheel_radius: 0.1, velocity_rolling_window_size: 3}}");
  EXPECT_THAT(told.yaml(), HasSubstr("velocity_rolling_window_size: 3"));
  EXPECT_THAT(told.yaml(), Not(HasSubstr("velocity_rolling_window_size: 10")));
}

TEST(RosImport, keeps_what_the_filter_serves_as_robot_localization_does_and_adds_nothing) {
  const Imported result = imported(R"(
ekf_filter_node:
  ros__parameters:
    odom0: odom
    use_control: true
    stamped_control: false
    base_link_frame_output: base_footprint
    tf_prefix: robot1
    disabled_at_startup: true
)");
  for (const char* key :
       {"use_control", "stamped_control", "base_link_frame_output", "tf_prefix", "disabled_at_startup"})
    EXPECT_THAT(note_of(result, key), testing::StartsWith("kept: ")) << key;
  EXPECT_THAT(result.yaml(), Not(HasSubstr("two_d_mode")));
}

TEST(RosImport, a_misspelt_key_is_a_comment_with_the_name_that_is_meant) {
  const Imported result = imported("base_controller: {ros__parameters: {wheel_radius: 0.1, wheel_seperation: 0.3}}");
  EXPECT_THAT(result.yaml(), HasSubstr("    # wheel_separation: 0.3  # 'wheel_seperation' in the file\n"));
  EXPECT_EQ(note_of(result, "wheel_seperation"),
            "doubted: old.yaml:1: /base_controller.wheel_seperation: diff_drive_controller has no such key and ignores "
            "it; did you mean 'wheel_separation'?");
}

TEST(RosImport, keeps_the_number_of_an_input_in_a_changed_name) {
  const Imported result =
      imported("ekf: {ros__parameters: {imu12: imu/data, imu12_angular_velocity_rejection_threshold: 0.8}}");
  EXPECT_THAT(result.yaml(), HasSubstr("imu12_twist_rejection_threshold: 0.8"));
}

TEST(RosImport, joins_what_usb_cam_keeps_apart) {
  const Imported result = imported(R"(
/front/usb_cam:
  ros__parameters: {framerate: 29.97, image_height: 720, image_width: 1280, pixel_format: mjpeg2rgb, brightness: -1}
)");
  EXPECT_EQ(result.yaml(), R"(/front/camera:
  ros__parameters:
    time_per_frame: [1000, 29970]
    output_encoding: rgb8
    pixel_format: MJPG
    image_size: [1280, 720]
)");
  EXPECT_THAT(note_of(result, "brightness"), HasSubstr("dropped: "));
}

TEST(RosImport, switches_of_the_filter_stay) {
  const Imported result = imported("ekf: {ros__parameters: {debug: true, smooth_lagged_data: true}}");
  EXPECT_THAT(result.yaml(), HasSubstr("debug: true"));
  EXPECT_THAT(result.yaml(), HasSubstr("smooth_lagged_data: true"));
}

TEST(RosImport, tells_the_driver_by_its_keys_where_the_node_has_no_name) {
  const Imported result = imported("/**: {ros__parameters: {image_size: [640, 480], time_per_frame: [1, 15]}}");
  ASSERT_EQ(result.nodes.size(), 1U);
  EXPECT_EQ(result.nodes[0].name, "camera");
}

TEST(RosImport, a_second_filter_keeps_its_own_name_and_the_base_is_made_of_two_sections) {
  const Imported result = imported(R"(
ekf_filter_node_odom: {ros__parameters: {world_frame: odom}}
ekf_filter_node_map: {ros__parameters: {world_frame: map}}
controller_manager: {ros__parameters: {update_rate: 30}}
diffbot_base_controller: {ros__parameters: {wheel_radius: 0.1}}
)");
  std::vector<std::string> names;
  for (const auto& node : result.nodes) names.push_back(node.name);
  EXPECT_THAT(names, testing::ElementsAre("ekf", "ekf_filter_node_map", "diff_drive", "odometry"));
  EXPECT_THAT(result.yaml(),
              HasSubstr("diff_drive:\n  ros__parameters:\n    update_rate: 30\n    wheel_radius: 0.1\n"));
}

std::string refusal(const std::string& text) {
  Imported result;
  const auto done = import_file(text, "old.yaml", result);
  return done ? "imported: " + result.yaml() : done.error().front().text();
}

TEST(RosImport, refuses_a_file_of_unknown_drivers_and_names_them) {
  EXPECT_THAT(
      refusal("slam_toolbox: {ros__parameters: {solver_plugin: x, resolution: 0.05}}"),
      HasSubstr(
          "old.yaml:1: the driver of '/slam_toolbox' is unknown: it is none of diff_drive_controller, twist_mux, "));
}

TEST(RosImport, keys_that_many_drivers_have_identify_none) {
  for (const char* text :
       {"mpu6050driver_node: {ros__parameters: {frequency: 100, frame_id: imu_link, range_max: 2}}",
        "slam_toolbox: {ros__parameters: {odom_frame: odom, map_frame: map, base_frame: base_link, transform_timeout: "
        "0.2, mode: "
        "mapping}}",
        "rplidar_node: {ros__parameters: {serial_port: /dev/ttyUSB0, serial_baudrate: 115200, frame_id: laser}}",
        "ekf_localizer: {ros__parameters: {publish_tf: true, tf_rate: 50.0, predict_frequency: 50.0, pose_frame_id: "
        "map}}",
        "amcl: {ros__parameters: {odom_frame_id: odom, base_frame_id: base, alpha1: 0.2}}",
        "imu_filter: {ros__parameters: {world_frame: enu, publish_tf: false, gain: 0.1, frequency: 30.0}}"}) {
    EXPECT_THAT(refusal(text), HasSubstr("is unknown")) << text;
  }
}

TEST(RosImport, keys_that_one_driver_has_identify_it_whatever_its_name) {
  EXPECT_THAT(imported("fusion: {ros__parameters: {frequency: 30.0, odom0: odom, odom0_config: [true]}}").yaml(),
              HasSubstr("ekf:\n"));
  EXPECT_THAT(imported("laser: {ros__parameters: {product_name: LDLiDAR_LD06, laser_scan_dir: true}}").yaml(),
              HasSubstr("lidar:\n"));
}

TEST(RosImport, keys_of_an_unknown_driver_beside_a_known_one_are_doubted) {
  const Imported result =
      imported("ekf: {ros__parameters: {frequency: 30.0}}\nslam_toolbox: {ros__parameters: {resolution: 0.05}}");
  EXPECT_THAT(note_of(result, "resolution"),
              HasSubstr("doubted: old.yaml:2: /slam_toolbox.resolution: the node's driver is unknown"));
}

TEST(RosImport, what_every_node_has_is_no_unknown_driver) {
  EXPECT_EQ(imported("/**: {ros__parameters: {use_sim_time: false}}").yaml(), "");
}

TEST(RosImport, gives_the_inputs_and_locks_of_a_multiplexer_to_the_base) {
  const Imported result = imported(R"(
twist_mux:
  ros__parameters:
    use_stamped: true
    topics:
      navigation: {topic: nav_vel, timeout: 0.5, priority: 10, short_desc: by itself}
    locks:
      pause: {topic: pause_navigation, timeout: 0.0, priority: 100}
)");
  EXPECT_EQ(result.yaml(), R"(diff_drive:
  ros__parameters:
    topics.navigation.topic: nav_vel
    topics.navigation.timeout: 0.5
    topics.navigation.priority: 10
    locks.pause.topic: pause_navigation
    locks.pause.timeout: 0.0
    locks.pause.priority: 100
)");
  EXPECT_THAT(note_of(result, "use_stamped"), HasSubstr("dropped: "));
}

TEST(RosImport, widens_a_list_of_doubles_that_holds_whole_numbers_and_warns) {
  const Imported result = imported("ekf: {ros__parameters: {initial_state: [1, 1.0, 0], frequency: 30.0}}");
  EXPECT_THAT(result.yaml(), HasSubstr("    initial_state: [1.0, 1.0, 0.0]\n"));
  EXPECT_EQ(result.notes.back().line().find("added: "), std::string::npos)
      << "the warning is the last word of the section";
  EXPECT_THAT(result.notes.back().line(),
              testing::AllOf(HasSubstr("doubted: old.yaml:1: /ekf.initial_state"), HasSubstr("ROS 2 refuses")));
}

TEST(RosImport, refuses_a_mixed_list_of_an_unknown_type) {
  EXPECT_THAT(refusal("ekf: {ros__parameters: {odom0: odom, odom0_mix: [1, 1.0]}}"), HasSubstr("mixes int and double"));
}

TEST(RosImport, what_is_no_parameter_file_is_a_problem_with_its_line) {
  for (const char* text : {"a: [1, 2", "a: 3", "- a", "a: {b: {ros__parameters: 3}}", "&a [*a]"}) {
    Imported result;
    const auto done = import_file(text, "old.yaml", result);
    ASSERT_FALSE(done) << text;
    EXPECT_THAT(done.error().front().where.text(), HasSubstr("old.yaml")) << text;
  }
}

TEST(RosImport, what_is_written_reads_back_as_the_same) {
  const Imported result = imported(R"(
ekf:
  ros__parameters: {odom0: 'true', odom0_config: [true, false], frequency: 5, map_frame: "a: b # c", imu0: "line\nbreak"}
)");
  const auto again = launch::parse_parameter_file(result.yaml(), "new.yaml");
  ASSERT_TRUE(again) << again.error().front().text() << "\n" << result.yaml();
  std::map<std::string, ParameterValue> values;
  for (const auto& parameter : again.value().parameters_for("/ekf")) values[parameter.name] = parameter.value;
  for (const auto& line : result.nodes.at(0).lines) EXPECT_EQ(values[line.name], line.value) << line.name;
}

TEST(RosImport, every_row_says_what_becomes_of_its_key) {
  for (const Driver& driver : drivers()) {
    std::set<std::string_view> seen;
    for (const Key& key : driver.keys) {
      SCOPED_TRACE(std::string{driver.name} + " " + std::string{key.name});
      EXPECT_TRUE(seen.insert(key.name).second) << "twice";
      const bool needs_reason = key.fate == Fate::Dropped || (key.fate == Fate::Doubted && key.nodes.empty());
      EXPECT_TRUE(!needs_reason || !key.text.empty());
      EXPECT_EQ(find_key(driver, key.name) != nullptr, key.name.find('#') == std::string_view::npos)
          << "a row is found by its own name, but for one with a number";
    }
  }
}

TEST(DriverTable, compiled_in_table_is_valid_and_writes_to_nacelles_nodes_only) {
  const auto table = read_table(kDriversYaml, "drivers.yaml");
  ASSERT_TRUE(table) << table.error().front().text();
  const std::set<std::string> nodes{"",
                                    "diff_drive",
                                    "odometry",
                                    "ekf",
                                    "camera",
                                    "lidar",
                                    "gps",
                                    "joy_node",
                                    "navsat_transform",
                                    "teleop_twist_joy_node"};
  for (const Driver& driver : table->drivers) {
    EXPECT_TRUE(nodes.contains(driver.node)) << driver.name;
    for (const Key& key : driver.keys) {
      for (const auto& node : key.nodes) EXPECT_TRUE(nodes.contains(node)) << driver.name << " " << key.name;
    }
  }
}

TEST(DriverTable, each_generic_key_is_a_key_of_a_driver) {
  for (const auto& name : table().generic) {
    EXPECT_TRUE(std::ranges::any_of(drivers(), [&](const Driver& one) { return find_key(one, name) != nullptr; }))
        << name;
  }
}

TEST(DriverTable, reports_each_mistake_with_its_line) {
  const std::string head = "drivers:\n- name: a\n  named: [a]\n  keys:\n";
  const std::vector<std::pair<std::string, const char*>> mistakes{
      {head + "  - kept: [b]\n    to_node: c", "t.yaml:6: 'to_node' means nothing here"},
      {head + "  - {text: why}", "t.yaml:5: a row says one fate"},
      {head + "  - dropped: [b]", "t.yaml:5: 'b' needs a reason"},
      {head + "  - {translated: [b], values: {c: d}}", "t.yaml:5: 'b' needs `otherwise`"},
      {head + "  - {translated: [b], nodes: c}", "t.yaml:5: a list is needed, not text"},
      {head + "  - {kept: [b], text: [c]}", "t.yaml:5: text is needed, not a list"},
      {"drivers:\n- name: a", "t.yaml:2: a driver has"},
      {"every_node: []", "t.yaml:1: there are no drivers"},
      {"a: [", "t.yaml:1: this is not YAML"}};
  for (const auto& [text, problem] : mistakes) {
    const auto table = read_table(text, "t.yaml");
    ASSERT_FALSE(table) << text;
    EXPECT_THAT(table.error().front().text(), testing::StartsWith(problem)) << text;
  }
}

TEST(RosImport, navsat_transform_keeps_its_parameters) {
  const Imported result = imported(
      "navsat_transform: {ros__parameters: {frequency: 30.0, delay: 3.0, yaw_offset: 1.57, datum: [55.9, -3.1, 0.0]}}");
  EXPECT_THAT(result.yaml(), HasSubstr("navsat_transform:"));
  EXPECT_THAT(result.yaml(), HasSubstr("yaw_offset: 1.57"));
  EXPECT_THAT(note_of(result, "frequency"), HasSubstr("kept: "));
}

TEST(RosImport, what_only_an_unscented_filter_has_is_said_to_be_its) {
  const Imported result = imported("ukf_filter_node: {ros__parameters: {frequency: 30.0, alpha: 0.001}}");
  EXPECT_THAT(note_of(result, "alpha"), HasSubstr("of the unscented filter"));
}

TEST(RosImport, numbers_and_switches_of_v4l2_camera_are_controls) {
  const Imported result = imported("v4l2_camera: {ros__parameters: {led1_mode: 1, brightnes: 5, zz_unheard: of}}");
  EXPECT_THAT(result.yaml(), HasSubstr("    led1_mode: 1\n"));
  EXPECT_THAT(note_of(result, "led1_mode"), HasSubstr("kept: "));
  EXPECT_THAT(note_of(result, "brightnes"), HasSubstr("did you mean 'brightness'?"));
  EXPECT_THAT(note_of(result, "zz_unheard"), HasSubstr("Nacelle knows no such key"));
}

TEST(RosImport, what_belongs_to_an_input_that_is_not_given_is_dropped) {
  const Imported result =
      imported("ekf: {ros__parameters: {odom0: odom, odom0_queue_size: 2, imu0_config: [true], imu0_queue_size: 2}}");
  EXPECT_THAT(result.yaml(), Not(HasSubstr("imu0")));
  EXPECT_THAT(result.yaml(), HasSubstr("odom0_queue_size: 2"));
  EXPECT_EQ(note_of(result, "imu0_config"),
            "dropped: old.yaml:1: /ekf.imu0_config: belongs to imu0, which the file does not give");
}

TEST(RosImport, says_what_is_not_used_though_it_could_be_written) {
  EXPECT_THAT(note_of(imported("ekf: {ros__parameters: {debug_out_file: /tmp/x}}"), "debug_out_file"),
              HasSubstr("dropped: "));
  const Imported lidar = imported("ldlidar_node: {ros__parameters: {comm: {direct_serial: true, sync_mode: true}}}");
  EXPECT_THAT(note_of(lidar, "comm.direct_serial"), HasSubstr("dropped: "));
  EXPECT_THAT(note_of(lidar, "comm.sync_mode"), HasSubstr("dropped: "));
}

TEST(RosImport, does_not_write_over_what_it_reads) {
  EXPECT_FALSE(may_write("a.yaml", {"b.yaml", "a.yaml"}));
  EXPECT_FALSE(may_write("/proc/self/../self/status", {"/proc/self/status"})) << "another name of the same file";
  EXPECT_TRUE(may_write("c.yaml", {"b.yaml", "a.yaml"}));
  EXPECT_TRUE(may_write("", {"a.yaml"}));
}

}  // namespace
}  // namespace nacelle::ros_import
