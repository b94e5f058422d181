// SPDX-License-Identifier: Apache-2.0
// Sources: ros2_controllers jazzy (diff_drive_controller_parameter.yaml) and its older releases, robot_localization ros2
// (ros_filter.cpp, params/ekf.yaml), teleop_twist_joy, twist_mux (rolling, config/twist_mux_topics.yaml and _locks.yaml), v4l2_camera 0.7,
// usb_cam 0.8, ldlidar_stl_ros2, ldrobot-lidar-ros2.
#include "ros_import/drivers.hpp"

#include <array>
#include <cctype>

namespace nacelle::ros_import {
namespace {

using enum Fate;

constexpr std::array kCommon{
    Key{"use_sim_time", Kept},
    Key{"qos_overrides.*", Dropped, "", "", "a launch file's `qos:` changes the quality of service of a topic"},
    Key{"*.image_transport", Dropped, "", "", "images travel without a copy and without a plugin"},
    Key{"start_type_description_service", Dropped, "", "", "the container offers it for every node"},
};

constexpr std::string_view kBoth = "diff_drive odometry";

// --- diff_drive_controller and what stands around it ----------------------------------------------------------------------

constexpr std::array kDiffDrive{
    Key{"left_wheel_names", Translated, kBoth, "", "the base drives the wheels, the odometry reads them"},
    Key{"right_wheel_names", Translated, kBoth, "", "the base drives the wheels, the odometry reads them"},
    Key{"wheel_separation", Translated, kBoth},
    Key{"wheel_radius", Translated, kBoth},
    Key{"wheel_separation_multiplier", Translated, kBoth},
    Key{"left_wheel_radius_multiplier", Translated, kBoth},
    Key{"right_wheel_radius_multiplier", Translated, kBoth},
    Key{"wheels_per_side", Dropped, "", "", "the lists of wheel names say it (ros2_control dropped it, too)"},
    Key{"left_wheel_name", Translated, kBoth, "left_wheel_names", "the old name for one wheel"},
    Key{"right_wheel_name", Translated, kBoth, "right_wheel_names", "the old name for one wheel"},
    Key{"left_wheel", Translated, kBoth, "left_wheel_names", "the name of ROS 1"},
    Key{"right_wheel", Translated, kBoth, "right_wheel_names", "the name of ROS 1"},
    Key{"wheel_separation_h", Doubted, "", "", "of another controller (four wheels, or steering)"},
    Key{"odom_frame_id", Translated, "odometry"},
    Key{"base_frame_id", Translated, "odometry"},
    Key{"enable_odom_tf", Translated, "odometry"},
    Key{"velocity_rolling_window_size", Translated, "odometry"},
    Key{"pose_covariance_diagonal", Doubted, "odometry", "",
        "taken over, but there it is constant: here x, y and yaw grow from it"},
    Key{"twist_covariance_diagonal", Doubted, "odometry", "",
        "taken over, but there it is constant: here it is the least, and x and yaw grow with the speed"},
    Key{"cmd_vel_timeout", Translated, "diff_drive"},
    Key{"publish_limited_velocity", Translated, "diff_drive"},
    Key{"publish_rate", Translated, "diff_drive", "", "of joint states; the odometry follows them"},
    Key{"update_rate", Translated, "diff_drive"},
    Key{"linear.x.max_velocity", Translated, "diff_drive"},
    Key{"linear.x.min_velocity", Translated, "diff_drive"},
    Key{"linear.x.max_acceleration", Translated, "diff_drive"},
    Key{"linear.x.max_deceleration", Translated, "diff_drive"},
    Key{"linear.x.max_acceleration_reverse", Translated, "diff_drive"},
    Key{"linear.x.max_deceleration_reverse", Translated, "diff_drive"},
    Key{"linear.x.max_jerk", Translated, "diff_drive"},
    Key{"linear.x.min_jerk", Translated, "diff_drive"},
    Key{"linear.x.min_acceleration", Translated, "diff_drive", "",
        "deprecated: max_deceleration and max_acceleration_reverse say it better"},
    Key{"linear.x.has_velocity_limits", Translated, "diff_drive", "", "deprecated: a limit of .nan is none"},
    Key{"linear.x.has_acceleration_limits", Translated, "diff_drive", "", "deprecated: a limit of .nan is none"},
    Key{"linear.x.has_jerk_limits", Translated, "diff_drive", "", "deprecated: a limit of .nan is none"},
    Key{"angular.z.max_velocity", Translated, "diff_drive"},
    Key{"angular.z.min_velocity", Translated, "diff_drive"},
    Key{"angular.z.max_acceleration", Translated, "diff_drive"},
    Key{"angular.z.max_deceleration", Translated, "diff_drive"},
    Key{"angular.z.max_acceleration_reverse", Translated, "diff_drive"},
    Key{"angular.z.max_deceleration_reverse", Translated, "diff_drive"},
    Key{"angular.z.max_jerk", Translated, "diff_drive"},
    Key{"angular.z.min_jerk", Translated, "diff_drive"},
    Key{"angular.z.min_acceleration", Translated, "diff_drive", "",
        "deprecated: max_deceleration and max_acceleration_reverse say it better"},
    Key{"angular.z.has_velocity_limits", Translated, "diff_drive", "", "deprecated: a limit of .nan is none"},
    Key{"angular.z.has_acceleration_limits", Translated, "diff_drive", "", "deprecated: a limit of .nan is none"},
    Key{"angular.z.has_jerk_limits", Translated, "diff_drive", "", "deprecated: a limit of .nan is none"},
    Key{"use_stamped_vel", Translated, "diff_drive"},
    Key{"open_loop", Doubted, "", "", "the odometry reads the wheels, always; true has no counterpart"},
    Key{"position_feedback", Doubted, "", "", "the odometry reads positions; false has no counterpart"},
    Key{"tf_frame_prefix_enable", Dropped, "", "", "write the prefix into odom_frame_id and base_frame_id"},
    Key{"tf_frame_prefix", Doubted, "", "", "write the prefix into odom_frame_id and base_frame_id"},
    Key{"command_interface", Dropped, "", "", "the motor board is spoken to directly"},
    Key{"command_interfaces", Dropped, "", "", "the motor board is spoken to directly"},
    Key{"state_interfaces", Dropped, "", "", "the motor board is spoken to directly"},
    Key{"allow_multiple_cmd_vel_publishers", Dropped, "", "", "every publisher of cmd_vel is heard"},
    Key{"type", Dropped, "", "", "a launch file's `plugin` says it"},
};
constexpr std::array kDiffDriveDefaults{
    Default{"odometry", "velocity_rolling_window_size", "10", "diff_drive_controller's default; Nacelle's is 1"},
};

// The base takes the place of the multiplexer: its inputs and locks have the same structure.
constexpr std::array kTwistMux{
    Key{"topics.*.topic", Translated, "diff_drive"},
    Key{"topics.*.timeout", Translated, "diff_drive"},
    Key{"topics.*.priority", Translated, "diff_drive"},
    Key{"topics.*.short_desc", Dropped, "", "", "the input's own name says it"},
    Key{"locks.*.topic", Translated, "diff_drive"},
    Key{"locks.*.timeout", Translated, "diff_drive"},
    Key{"locks.*.priority", Translated, "diff_drive"},
    Key{"locks.*.short_desc", Dropped, "", "", "the lock's own name says it"},
    Key{"use_stamped", Dropped, "", "", "the base takes Twist and TwistStamped alike"},
    Key{"output_stamped", Dropped, "", "", "the base takes Twist and TwistStamped alike"},
};

constexpr std::array kControllerManager{
    Key{"update_rate", Translated, "diff_drive", "", "control cycles per second of the base"},
    Key{"*.type", Dropped, "", "", "a launch file's `plugin` says it"},
    Key{"hardware_components_initial_state.*", Dropped, "", "", "the lifecycle manager brings every component up"},
    Key{"enforce_command_limits", Dropped, "", "", "the base always keeps its limits"},
    Key{"handle_exceptions", Dropped, "", "", "an exception faults its component, always"},
    Key{"lock_memory", Dropped, "", "", "see docs/performance.md"},
    Key{"cpu_affinity", Doubted, "", "", "write `thread: {mode: own, cpus: ...}` in the launch file"},
    Key{"thread_priority", Doubted, "", "", "write `thread: {mode: own, priority: ...}` in the launch file"},
    Key{"overruns.*", Dropped, "", "", "missed cycles are counted, always"},
    Key{"diagnostics.*", Dropped, "", "", "the monitor component judges rates"},
    Key{"defaults.*", Dropped, "", "", "there are no controllers to switch"},
    Key{"shutdown_on_initial_state_failure", Dropped, "", "", "`required:` in the launch file says it"},
};
constexpr std::array kJointStateBroadcaster{
    Key{"*", Dropped, "", "", "the base publishes joint_states itself"},
};

// --- robot_localization ---------------------------------------------------------------------------------------------------

constexpr std::string_view kOnlyFalse = "Nacelle's filter serves false only";
constexpr std::string_view kUnscented = "of the unscented filter; Nacelle's is the extended one, with the other keys";
constexpr std::array kEkf{
    Key{"frequency"},
    Key{"sensor_timeout"},
    Key{"two_d_mode"},
    Key{"predict_to_current_time"},
    Key{"transform_time_offset"},
    Key{"transform_timeout"},
    Key{"print_diagnostics"},
    Key{"map_frame"},
    Key{"odom_frame"},
    Key{"base_link_frame"},
    Key{"world_frame"},
    Key{"publish_tf"},
    Key{"publish_acceleration"},
    Key{"gravitational_acceleration"},
    Key{"dynamic_process_noise_covariance"},
    Key{"process_noise_covariance"},
    Key{"initial_estimate_covariance"},
    Key{"initial_state"},
    Key{"history_length"},
    Key{"debug_out_file", Dropped, "", "", "of debug, which Nacelle's filter does not have"},
    Key{"control_timeout"},
    Key{"control_config"},
    Key{"acceleration_limits"},
    Key{"acceleration_gains"},
    Key{"deceleration_limits"},
    Key{"deceleration_gains"},
    Key{"smooth_lagged_data", Kept, "", "", kOnlyFalse},
    Key{"use_control"},
    Key{"stamped_control"},
    Key{"permit_corrected_publication", Kept, "", "", kOnlyFalse},
    Key{"reset_on_time_jump", Kept, "", "", kOnlyFalse},
    Key{"debug", Kept, "", "", kOnlyFalse},
    Key{"base_link_frame_output"},
    Key{"alpha", Doubted, "", "", kUnscented},
    Key{"kappa", Doubted, "", "", kUnscented},
    Key{"beta", Doubted, "", "", kUnscented},
    Key{"base_footprint_frame", Dropped, "", "", "no longer used"},
    Key{"tf_prefix"},
    Key{"disabled_at_startup"},
    Key{"odom#"},
    Key{"pose#"},
    Key{"twist#"},
    Key{"imu#"},
    Key{"odom#_config"},
    Key{"pose#_config"},
    Key{"twist#_config"},
    Key{"imu#_config"},
    Key{"odom#_queue_size"},
    Key{"pose#_queue_size"},
    Key{"twist#_queue_size"},
    Key{"imu#_queue_size"},
    Key{"odom#_differential"},
    Key{"pose#_differential"},
    Key{"imu#_differential"},
    Key{"odom#_relative"},
    Key{"pose#_relative"},
    Key{"imu#_relative"},
    Key{"odom#_pose_rejection_threshold"},
    Key{"odom#_twist_rejection_threshold"},
    Key{"pose#_rejection_threshold"},
    Key{"twist#_rejection_threshold"},
    Key{"imu#_pose_rejection_threshold"},
    Key{"imu#_twist_rejection_threshold"},
    Key{"imu#_linear_acceleration_rejection_threshold"},
    Key{"odom#_pose_use_child_frame"},
    Key{"imu#_remove_gravitational_acceleration"},
    Key{"imu#_angular_velocity_rejection_threshold", Translated, "", "imu#_twist_rejection_threshold", "an older name"},
    Key{"odom#_nodelay", Dropped, "", "", "messages do not go through TCP"},
    Key{"pose#_nodelay", Dropped, "", "", "messages do not go through TCP"},
    Key{"twist#_nodelay", Dropped, "", "", "messages do not go through TCP"},
    Key{"imu#_nodelay", Dropped, "", "", "messages do not go through TCP"},
    Key{"twist#_differential", Dropped, "", "", "a velocity has no difference to take"},
    Key{"twist#_relative", Dropped, "", "", "a velocity is relative to nothing"},
};

constexpr std::string_view kNoNavsat =
    "Nacelle has no navsat_transform: run robot_localization's, and give its odometry/gps to the filter";
constexpr std::array kNavsat{
    Key{"delay", Doubted, "", "", kNoNavsat},
    Key{"frequency", Doubted, "", "", kNoNavsat},
    Key{"magnetic_declination_radians", Doubted, "", "", kNoNavsat},
    Key{"yaw_offset", Doubted, "", "", kNoNavsat},
    Key{"zero_altitude", Doubted, "", "", kNoNavsat},
    Key{"publish_filtered_gps", Doubted, "", "", kNoNavsat},
    Key{"use_odometry_yaw", Doubted, "", "", kNoNavsat},
    Key{"wait_for_datum", Doubted, "", "", kNoNavsat},
    Key{"datum", Doubted, "", "", kNoNavsat},
    Key{"broadcast_utm_transform", Doubted, "", "", kNoNavsat},
    Key{"broadcast_utm_transform_as_parent_frame", Doubted, "", "", kNoNavsat},
    Key{"broadcast_cartesian_transform", Doubted, "", "", kNoNavsat},
    Key{"broadcast_cartesian_transform_as_parent_frame", Doubted, "", "", kNoNavsat},
    Key{"use_local_cartesian", Doubted, "", "", kNoNavsat},
    Key{"transform_timeout", Doubted, "", "", kNoNavsat},
};

// --- teleop_twist_joy -----------------------------------------------------------------------------------------------------

constexpr std::string_view kNoJoy =
    "Nacelle has no joystick component: run teleop_twist_joy where the joystick is, or `nacelle teleop`";
constexpr std::array kTeleop{
    Key{"require_enable_button", Doubted, "", "", kNoJoy},
    Key{"enable_button", Doubted, "", "", kNoJoy},
    Key{"enable_turbo_button", Doubted, "", "", kNoJoy},
    Key{"axis_linear.x", Doubted, "", "", kNoJoy},
    Key{"axis_linear.y", Doubted, "", "", kNoJoy},
    Key{"axis_linear.z", Doubted, "", "", kNoJoy},
    Key{"axis_angular.yaw", Doubted, "", "", kNoJoy},
    Key{"axis_angular.pitch", Doubted, "", "", kNoJoy},
    Key{"axis_angular.roll", Doubted, "", "", kNoJoy},
    Key{"scale_linear.x", Doubted, "", "", kNoJoy},
    Key{"scale_linear.y", Doubted, "", "", kNoJoy},
    Key{"scale_linear.z", Doubted, "", "", kNoJoy},
    Key{"scale_angular.yaw", Doubted, "", "", kNoJoy},
    Key{"scale_angular.pitch", Doubted, "", "", kNoJoy},
    Key{"scale_angular.roll", Doubted, "", "", kNoJoy},
    Key{"scale_linear_turbo.x", Doubted, "", "", kNoJoy},
    Key{"scale_linear_turbo.y", Doubted, "", "", kNoJoy},
    Key{"scale_linear_turbo.z", Doubted, "", "", kNoJoy},
    Key{"scale_angular_turbo.yaw", Doubted, "", "", kNoJoy},
    Key{"scale_angular_turbo.pitch", Doubted, "", "", kNoJoy},
    Key{"scale_angular_turbo.roll", Doubted, "", "", kNoJoy},
    Key{"publish_stamped_twist", Doubted, "", "", kNoJoy},
    Key{"frame", Doubted, "", "", kNoJoy},
    Key{"inverted_reverse", Doubted, "", "", kNoJoy},
    // Of before foxy: one number for x or yaw, which later versions do not read.
    Key{"axis_linear", Doubted, "", "", "a name of ROS 1: teleop_twist_joy reads axis_linear.x"},
    Key{"axis_angular", Doubted, "", "", "a name of ROS 1: teleop_twist_joy reads axis_angular.yaw"},
    Key{"scale_linear", Doubted, "", "", "a name of ROS 1: teleop_twist_joy reads scale_linear.x"},
    Key{"scale_angular", Doubted, "", "", "a name of ROS 1: teleop_twist_joy reads scale_angular.yaw"},
    Key{"scale_linear_turbo", Doubted, "", "", "a name of ROS 1: teleop_twist_joy reads scale_linear_turbo.x"},
    Key{"scale_angular_turbo", Doubted, "", "", "a name of ROS 1: teleop_twist_joy reads scale_angular_turbo.yaw"},
};
constexpr std::array kJoy{
    Key{"device_id", Doubted, "", "", kNoJoy},
    Key{"device_name", Doubted, "", "", kNoJoy},
    Key{"dev", Doubted, "", "", kNoJoy},
    Key{"deadzone", Doubted, "", "", kNoJoy},
    Key{"autorepeat_rate", Doubted, "", "", kNoJoy},
    Key{"sticky_buttons", Doubted, "", "", kNoJoy},
    Key{"coalesce_interval_ms", Doubted, "", "", kNoJoy},
    Key{"coalesce_interval", Doubted, "", "", kNoJoy},
};

// --- cameras --------------------------------------------------------------------------------------------------------------

constexpr std::string_view kControl = "a control of the camera, if it has one of that name";
constexpr std::array kV4l2{
    Key{"video_device"},
    Key{"pixel_format"},
    Key{"output_encoding"},
    Key{"image_size"},
    Key{"time_per_frame"},
    Key{"camera_frame_id", Kept, "", "", "the frame of the headers is the optical one: x right, y down, z forward"},
    Key{"camera_info_url"},
    Key{"use_v4l2_buffer_timestamps"},
    Key{"timestamp_offset"},
    Key{"brightness", Kept, "", "", kControl},
    Key{"contrast", Kept, "", "", kControl},
    Key{"saturation", Kept, "", "", kControl},
    Key{"hue", Kept, "", "", kControl},
    Key{"gamma", Kept, "", "", kControl},
    Key{"gain", Kept, "", "", kControl},
    Key{"sharpness", Kept, "", "", kControl},
    Key{"exposure_auto", Kept, "", "", kControl},
    Key{"auto_exposure", Kept, "", "", kControl},
    Key{"exposure_absolute", Kept, "", "", kControl},
    Key{"exposure_time_absolute", Kept, "", "", kControl},
    Key{"exposure_auto_priority", Kept, "", "", kControl},
    Key{"power_line_frequency", Kept, "", "", kControl},
    Key{"white_balance_temperature", Kept, "", "", kControl},
    Key{"white_balance_temperature_auto", Kept, "", "", kControl},
    Key{"white_balance_automatic", Kept, "", "", kControl},
    Key{"backlight_compensation", Kept, "", "", kControl},
    Key{"focus_auto", Kept, "", "", kControl},
    Key{"focus_absolute", Kept, "", "", kControl},
    Key{"zoom_absolute", Kept, "", "", kControl},
    Key{"image_raw.*", Dropped, "", "", "of image_transport, whose plugins are not here"},
    Key{"camera_link", Doubted, "", "", "no parameter of v4l2_camera: camera_frame_id names the frame"},
};
constexpr std::array kUsbCam{
    Key{"video_device"},
    Key{"camera_info_url"},
    Key{"camera_frame_id", Kept, "", "", "the frame of the headers is the optical one: x right, y down, z forward"},
    Key{"frame_id", Translated, "", "camera_frame_id",
        "the frame of the headers is the optical one: x right, y down, z forward"},
    Key{"framerate", Translated, "", "time_per_frame"},
    Key{"image_width", Translated, "", "image_size"},
    Key{"image_height", Translated, "", "image_size"},
    Key{"pixel_format", Translated, "", "pixel_format"},
    Key{"camera_name", Dropped, "", "", "the calibration's file names its camera"},
    Key{"io_method", Dropped, "", "", "buffers are mapped, always: that is what makes them free of copies"},
    Key{"av_device_format", Dropped, "", "", "of a library that is not used here"},
    Key{"image_raw.*", Dropped, "", "", "of image_transport, whose plugins are not here"},
    Key{"brightness", Translated, "", "", kControl},
    Key{"contrast", Translated, "", "", kControl},
    Key{"saturation", Translated, "", "", kControl},
    Key{"sharpness", Translated, "", "", kControl},
    Key{"gain", Translated, "", "", kControl},
    Key{"auto_white_balance", Translated, "", "white_balance_automatic", kControl},
    Key{"white_balance", Translated, "", "white_balance_temperature", kControl},
    Key{"autoexposure", Doubted, "", "", "V4L2's auto_exposure is a number: 3 automatic, 1 by hand; see v4l2-ctl -L"},
    Key{"exposure", Translated, "", "exposure_time_absolute", kControl},
    Key{"autofocus", Translated, "", "focus_automatic_continuous", kControl},
    Key{"focus", Translated, "", "focus_absolute", kControl},
};

// --- LD06 -----------------------------------------------------------------------------------------------------------------

constexpr std::array kLd06{
    Key{"product_name"},
    Key{"topic_name"},
    Key{"frame_id"},
    Key{"port_name"},
    Key{"port_baudrate"},
    Key{"laser_scan_dir"},
    Key{"enable_angle_crop_func"},
    Key{"angle_crop_min"},
    Key{"angle_crop_max"},
    Key{"range_min"},
    Key{"range_max"},
    Key{"serial_port", Translated, "", "port_name"},
    Key{"serial_baudrate", Translated, "", "port_baudrate"},
    Key{"lidar_frame", Translated, "", "frame_id"},
    Key{"laser_scan_topic_name", Translated, "", "topic_name"},
    Key{"bins", Translated, "", "scan_points"},
    Key{"communication_mode", Doubted, "", "", "a serial line is all that is served"},
    Key{"comm_mode", Doubted, "", "", "a serial line is all that is served"},
    Key{"server_ip", Doubted, "", "", "a serial line is all that is served"},
    Key{"server_port", Doubted, "", "", "a serial line is all that is served"},
    Key{"measure_point_freq", Dropped, "", "", "the device's own 4500 points per second"},
    Key{"point_cloud_2d_topic_name", Dropped, "", "", "a scan is published, no cloud"},
    Key{"pointcloud_2d_topic_name", Dropped, "", "", "a scan is published, no cloud"},
    Key{"range_threshold", Doubted, "", "", "range_min and range_max are what Nacelle has"},
    // ldrobot-lidar-ros2 puts its keys into groups.
    Key{"comm.serial_port", Translated, "", "port_name"},
    Key{"comm.baudrate", Translated, "", "port_baudrate"},
    Key{"comm.timeout_msec", Dropped, "", "", "silence_limit (s) is what Nacelle has"},
    Key{"comm.direct_serial", Dropped, "", "", "a UART and a USB adapter are opened alike"},
    Key{"comm.sync_mode", Dropped, "", "", "the driver waits for the device's bytes, always"},
    Key{"comm.direction", Dropped, "", "", "the LiDAR only sends"},
    Key{"general.debug_mode", Dropped, "", "", "`nacelle launch -v` is what Nacelle has"},
    Key{"lidar.model", Translated, "", "product_name"},
    Key{"lidar.frame_id", Translated, "", "frame_id"},
    Key{"lidar.rot_verse", Translated, "", "laser_scan_dir"},
    Key{"lidar.units", Dropped, "", "", "ranges are in metres, always"},
    Key{"lidar.bins", Translated, "", "scan_points"},
    Key{"lidar.range_min", Translated, "", "range_min"},
    Key{"lidar.range_max", Translated, "", "range_max"},
    Key{"lidar.enable_angle_crop", Translated, "", "enable_angle_crop_func"},
    Key{"lidar.angle_crop_min", Translated, "", "angle_crop_min"},
    Key{"lidar.angle_crop_max", Translated, "", "angle_crop_max"},
};

constexpr std::array kDrivers{
    Driver{"diff_drive_controller", "diff_drive_controller diffdrive_controller",
           "diff_drive diffdrive diffbot base_controller", "diff_drive", kDiffDrive, kDiffDriveDefaults},
    Driver{"twist_mux", "twist_mux", "mux", "diff_drive", kTwistMux},
    Driver{"controller_manager", "controller_manager", "", "diff_drive", kControllerManager},
    Driver{"joint_state_broadcaster", "joint_state_broadcaster joint_broad", "", "", kJointStateBroadcaster},
    Driver{"robot_localization", "ekf_filter ukf_filter robot_localization", "ekf ukf", "ekf", kEkf},
    Driver{"navsat_transform", "navsat_transform", "navsat", "", kNavsat},
    Driver{"teleop_twist_joy", "teleop_twist_joy", "teleop", "", kTeleop},
    Driver{"joy", "joy_node game_controller", "joy", "", kJoy},
    Driver{"v4l2_camera", "v4l2_camera", "v4l2", "camera", kV4l2},
    Driver{"usb_cam", "usb_cam", "", "camera", kUsbCam},
    Driver{"an LD06 driver", "ld06 ldlidar ld19", "ldrobot", "lidar", kLd06},
};

/// '#' stands for one digit or more, '*' for anything, the empty text included.
bool fits(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern.front() == '*') {
    for (std::size_t skip = 0; skip <= name.size(); ++skip) {
      if (fits(pattern.substr(1), name.substr(skip))) return true;
    }
    return false;
  }
  if (name.empty()) return false;
  if (pattern.front() == '#') {
    std::size_t digits = 0;
    while (digits < name.size() && std::isdigit(static_cast<unsigned char>(name[digits])) != 0) ++digits;
    return digits > 0 && fits(pattern.substr(1), name.substr(digits));
  }
  return pattern.front() == name.front() && fits(pattern.substr(1), name.substr(1));
}

const Key* find_in(std::span<const Key> keys, std::string_view name) {
  for (const Key& key : keys) {
    if (fits(key.name, name)) return &key;
  }
  return nullptr;
}

}  // namespace

std::span<const Driver> drivers() { return kDrivers; }
const Key* find_key(const Driver& driver, std::string_view name) { return find_in(driver.keys, name); }
const Key* find_common_key(std::string_view name) { return find_in(kCommon, name); }

}  // namespace nacelle::ros_import
