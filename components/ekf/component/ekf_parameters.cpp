// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/ekf_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>

#include "ekf/component/assist_parameters.hpp"
#include "ekf/component/history_options.hpp"
#include "ekf/component/wheeled_noise_parameters.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::ekf {
namespace {

struct Stem {
  InputKind kind;
  const char* word;
};
constexpr std::array<Stem, 4> kStems{
    {{InputKind::Odometry, "odom"}, {InputKind::Pose, "pose"}, {InputKind::Twist, "twist"}, {InputKind::Imu, "imu"}}};

ParameterDescriptor say(const char* text) { return {.description = text, .read_only = true}; }

std::vector<bool> preset_config(const std::string& name) {
  std::vector<bool> config(kStates, false);
  if (name == "odom0") config[kVx] = config[kVy] = true;
  if (name == "imu0") config[kVyaw] = true;
  return config;
}

void declare_input(Node& node, const NamedInput& input, bool preset) {
  const std::string& s = input.name;
  const char* const topic = !preset ? "" : input.kind == InputKind::Odometry ? "odom" : "imu/data_raw";
  node.declare_parameter(s, topic, say("Topic of the input."));
  node.declare_parameter(s + "_config", preset ? preset_config(s) : std::vector<bool>(kStates, false),
                         say("x y z, roll pitch yaw, vx vy vz, vroll vpitch vyaw, ax ay az: what to fuse of it."));
  node.declare_parameter(
      s + "_queue_size", 10,
      say("Messages that wait for the filter's thread; the oldest is dropped. A second of them (the rate in Hz) loses "
          "none while the process is paused for so long."));
  node.declare_parameter(s + "_adaptive_measurement_noise", false,
                         say("Raise the noise of its measurements to what is seen of it, by at most ten standard "
                             "deviations' worth; never below "
                             "what its covariance says."));
  constexpr double kOff = std::numeric_limits<double>::max();
  const ParameterDescriptor gate =
      say("Largest Mahalanobis distance (not squared) that is fused; by default there is no limit.");
  if (input.kind != InputKind::Twist) {
    node.declare_parameter(s + "_differential", false, say("Fuse differences of poses as velocities."));
    node.declare_parameter(s + "_relative", false, say("Fuse poses relative to the first one."));
  }
  if (input.kind == InputKind::Odometry || input.kind == InputKind::Imu) {
    node.declare_parameter(s + "_pose_rejection_threshold", kOff, gate);
    node.declare_parameter(s + "_twist_rejection_threshold", kOff, gate);
  } else {
    node.declare_parameter(s + "_rejection_threshold", kOff, gate);
  }
  if (input.kind == InputKind::Odometry)
    node.declare_parameter(s + "_pose_use_child_frame", false, say("The pose is that of child_frame_id."));
  if (input.kind == InputKind::Imu) {
    node.declare_parameter(s + "_linear_acceleration_rejection_threshold", kOff, gate);
    node.declare_parameter(s + "_remove_gravitational_acceleration", false,
                           say("Subtract gravity from accelerations."));
  }
  declare_assist_switches(node, input.kind, s);
}

}  // namespace

std::vector<NamedInput> named_inputs(const Node& node) {
  std::vector<NamedInput> inputs;
  for (const Stem& stem : kStems) {
    for (int n = 0;; ++n) {
      std::string name = fmt::format("{}{}", stem.word, n);
      if (node.parameters().overrides().count(name) == 0) break;
      inputs.push_back({stem.kind, std::move(name)});
    }
  }
  if (inputs.empty() && inputs_behind_a_gap(node).empty())
    inputs = {{InputKind::Odometry, "odom0"}, {InputKind::Imu, "imu0"}};
  return inputs;
}

std::vector<std::string> inputs_behind_a_gap(const Node& node) {
  std::vector<std::string> behind;
  for (const auto& [name, value] : node.parameters().overrides()) {
    for (const Stem& stem : kStems) {
      const std::string word = stem.word;
      if (!name.starts_with(word) || name.size() == word.size() || name.size() > word.size() + 4) continue;
      const std::string digits = name.substr(word.size());
      if (!std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c) != 0; })) continue;
      for (int n = std::stoi(digits) - 1; n >= 0; --n) {
        if (node.parameters().overrides().count(fmt::format("{}{}", word, n)) == 0) {
          behind.push_back(name);
          break;
        }
      }
    }
  }
  return behind;
}

std::vector<std::string> inputs_without_config(const Node& node) {
  std::vector<std::string> found;
  const auto& given = node.parameters().overrides();
  for (NamedInput& input : named_inputs(node)) {
    if (given.count(input.name) != 0 && given.count(input.name + "_config") == 0)
      found.push_back(std::move(input.name));
  }
  return found;
}

std::vector<std::pair<std::string, std::string>> parameters_of_absent_inputs(const Node& node) {
  std::vector<std::pair<std::string, std::string>> found;
  for (const std::string& name : node.parameters().unused_overrides()) {
    for (const Stem& stem : kStems) {
      const std::string word = stem.word;
      if (!name.starts_with(word)) continue;
      const std::size_t end = std::min(name.find_first_not_of("0123456789", word.size()), name.size());
      if (end == word.size() || end == name.size() || name[end] != '_') continue;
      std::string input = name.substr(0, end);
      // One that is given, and has no such parameter, is another matter.
      if (node.parameters().overrides().count(input) == 0 && !node.has_parameter(input))
        found.emplace_back(name, std::move(input));
    }
  }
  return found;
}

void declare_ekf_parameters(Node& node) {
  const EkfOptions d;
  node.declare_parameter("frequency", d.frequency_hz, say("Outputs per second, Hz."));
  const auto frequency_hz = node.get<double>("frequency");
  node.declare_parameter("sensor_timeout", 1.0 / (frequency_hz > 0.0 ? frequency_hz : d.frequency_hz),
                         say("Silence after which the state is carried on to now, s; 1/frequency unless set."));
  node.declare_parameter("sensor_timeout_from_stamp", false,
                         say("Count the silence from the stamp of the last measurement, as robot_localization does; by "
                             "default from the output after its arrival, so that a late sensor is not a silent one."));
  node.declare_parameter("two_d_mode", d.filter.two_d_mode,
                         say("Hold z, roll, pitch, vz, vroll, vpitch and az at 0: for a robot on a plane."));
  node.declare_parameter("measurement_queue_limit", static_cast<std::int64_t>(d.filter.queue_limit),
                         say("The most measurements that wait for an output, 16 to 65536; 2 kB each, and only as many "
                             "as were needed. At the "
                             "limit the filter fuses what is due at once. If all that waits lies ahead of the clock, "
                             "the farthest is dropped."));
  node.declare_parameter("predict_to_current_time", false, say("Carry the state on to now before each output."));
  node.declare_parameter("transform_time_offset", 0.0, say("Added to the transform's stamp, s."));
  node.declare_parameter("transform_timeout", 0.0,
                         say("Kept for robot_localization's files: transforms are taken as they are, nothing waits."));
  node.declare_parameter("print_diagnostics", d.print_diagnostics,
                         say("Publish the counters of every input on /diagnostics once a second."));
  declare_frame_prefix(node);
  node.declare_parameter("map_frame", d.map_frame, say("The map's frame."));
  node.declare_parameter("odom_frame", d.odom_frame, say("The odometry's frame."));
  node.declare_parameter("base_link_frame", d.base_link_frame, say("The frame whose pose is estimated."));
  node.declare_parameter("world_frame", node.get<std::string>("odom_frame"),
                         say("map_frame or odom_frame; odom_frame unless set."));
  node.declare_parameter(
      "base_link_frame_output", "",
      say("The base's name in odometry/filtered, accel/filtered and the transform; base_link_frame unless set."));
  node.declare_parameter("tf_prefix", "",
                         say("Written before every frame's name, with a slash behind it, and behind frame_prefix."));
  node.declare_parameter("disabled_at_startup", false,
                         say("Take and publish nothing until the service enable is called."));
  node.declare_parameter("publish_tf", d.publish_tf, say("Broadcast the estimate as a transform."));
  node.declare_parameter("publish_acceleration", d.publish_acceleration, say("Publish accel/filtered."));
  node.declare_parameter("gravitational_acceleration", d.gravity_mps2,
                         say("Gravity that is subtracted from accelerations, m/s^2."));
  node.declare_parameter("robot_localization_rotations", false,
                         say("Take tilted mountings and differences of poses as robot_localization does (docs/ekf.md), "
                             "not as rotations."));
  node.declare_parameter("dynamic_process_noise_covariance", false,
                         say("Scale the pose's process noise by the velocity."));
  node.declare_parameter("process_noise_covariance", std::vector<double>{},
                         say("Per second: 15 numbers (diagonal), 225, or 36 (pose block)."));
  declare_wheeled_noise(node);
  node.declare_parameter("initial_estimate_covariance", std::vector<double>{},
                         say("15 numbers (diagonal), 225, or 36 (pose block)."));
  node.declare_parameter("initial_state", std::vector<double>{}, say("15 numbers; zeros unless set."));
  node.declare_parameter("debug", false,
                         say("Write every prediction and measurement, with the state behind it, into debug_out_file."));
  node.declare_parameter(
      "debug_out_file", "",
      say("A file in memory, kept to its last 8 to 16 MiB. A name without a slash in front is in the "
          "folder of the service or the user under /run, else in /dev/shm/nacelle-<uid>. By default "
          "robot_localization_debug.<node>.txt."));
  declare_history_parameters(node);
  node.declare_parameter("use_control", false, say("Predict with the velocity that cmd_vel commands."));
  node.declare_parameter(
      "stamped_control", false,
      say("cmd_vel is a TwistStamped, in base_link_frame or without a frame; a Twist has the time at which it came."));
  node.declare_parameter("control_timeout", 0.0,
                         say("A command that is older counts as zero, s. With 0 every command does at once."));
  node.declare_parameter("control_config", std::vector<bool>{},
                         say("vx vy vz, vroll vpitch vyaw: which velocities are commanded."));
  node.declare_parameter("acceleration_limits", std::vector<double>{},
                         say("The most that the prediction accelerates, m/s^2 and rad/s^2; 1 unless set."));
  node.declare_parameter("acceleration_gains", std::vector<double>{},
                         say("The acceleration is the gain times (command - velocity), 1/s; 1 unless set."));
  node.declare_parameter(
      "deceleration_limits", std::vector<double>{},
      say("The same while the base slows down, m/s^2 and rad/s^2; as acceleration_limits unless set."));
  node.declare_parameter("deceleration_gains", std::vector<double>{},
                         say("The same while the base slows down, 1/s; as acceleration_gains unless set."));
  declare_assist_numbers(node);
  const bool preset = named_inputs(node).size() == 2 && node.parameters().overrides().count("odom0") == 0 &&
                      node.parameters().overrides().count("imu0") == 0;
  for (const NamedInput& input : named_inputs(node)) declare_input(node, input, preset);
}

}  // namespace nacelle::ekf
