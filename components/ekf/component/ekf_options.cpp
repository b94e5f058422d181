// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/ekf_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ekf/component/assist_parameters.hpp"
#include "ekf/component/debug_file.hpp"
#include "ekf/component/ekf_parameters.hpp"
#include "ekf/component/history_options.hpp"
#include "ekf/component/wheeled_noise_parameters.hpp"
#include "ekf/model/covariance_parameter.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::ekf {
namespace {

Problem wrong(const std::string& parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter), std::move(what), std::move(way_out)};
}

double gate_of(const Node& node, const std::string& name) {
  const double distance = node.get<double>(name);
  return distance >= std::numeric_limits<double>::max() ? std::numeric_limits<double>::infinity() : distance;
}

Result<InputOptions, Problem> read_input(const Node& node, const NamedInput& named) {
  const std::string& s = named.name;
  InputOptions input;
  input.kind = named.kind;
  input.name = s;
  input.topic = node.get<std::string>(s);
  if (input.topic.empty()) return err(wrong(s, "is empty", "give the topic of the input"));
  const auto config = node.get<std::vector<bool>>(s + "_config");
  if (config.size() != kStates) {
    return err(wrong(s + "_config", fmt::format("has {} booleans", config.size()),
                     "give 15: x y z, roll pitch yaw, vx vy vz, vroll vpitch vyaw, ax ay az"));
  }
  for (int i = 0; i < kStates; ++i) {
    if (config[static_cast<std::size_t>(i)]) input.config = static_cast<StateMask>(input.config | 1U << i);
  }
  const std::int64_t depth = node.get<std::int64_t>(s + "_queue_size");
  if (depth < 1 || depth > 1000) return err(wrong(s + "_queue_size", fmt::format("is {}", depth), "give 1 to 1000"));
  input.queue_size = static_cast<int>(depth);
  input.adaptive_measurement_noise = node.get<bool>(s + "_adaptive_measurement_noise");
  if (input.kind != InputKind::Twist) {
    input.differential = node.get<bool>(s + "_differential");
    input.relative = node.get<bool>(s + "_relative");
  }
  switch (input.kind) {
    case InputKind::Imu:
      input.acceleration_gate = gate_of(node, s + "_linear_acceleration_rejection_threshold");
      input.remove_gravitational_acceleration = node.get<bool>(s + "_remove_gravitational_acceleration");
      [[fallthrough]];
    case InputKind::Odometry:
      input.pose_gate = gate_of(node, s + "_pose_rejection_threshold");
      input.twist_gate = gate_of(node, s + "_twist_rejection_threshold");
      if (input.kind == InputKind::Odometry) input.pose_use_child_frame = node.get<bool>(s + "_pose_use_child_frame");
      break;
    case InputKind::Pose: input.pose_gate = gate_of(node, s + "_rejection_threshold"); break;
    case InputKind::Twist: input.twist_gate = gate_of(node, s + "_rejection_threshold"); break;
  }
  for (const double gate : {input.pose_gate, input.twist_gate, input.acceleration_gate}) {
    if (!(gate > 0.0))
      return err(wrong(s, fmt::format("a rejection threshold of it is {}", gate), "give a positive distance"));
  }
  read_assist_switches(node, input);
  return input;
}

Result<void, Problem> read_covariance_of(const Node& node, const char* name, StateMatrix& matrix, EkfOptions& options) {
  const auto numbers = node.get<std::vector<double>>(name);
  if (numbers.empty()) return {};
  auto read = read_covariance(numbers, matrix);
  if (!read) return err(wrong(name, read.error(), ""));
  matrix = read->matrix;
  if (!read->note.empty()) options.notes.push_back(fmt::format("{}: {}", name, read->note));
  return {};
}

Result<void, Problem> read_filter(const Node& node, EkfOptions& options) {
  FilterOptions& filter = options.filter;
  StateMatrix noise = default_process_noise();
  StateMatrix initial = default_initial_covariance();
  if (const auto read = read_covariance_of(node, "process_noise_covariance", noise, options); !read)
    return err(read.error());
  if (const auto read = read_covariance_of(node, "initial_estimate_covariance", initial, options); !read)
    return err(read.error());
  filter.process_noise = ProcessNoise{noise};
  filter.initial.covariance = initial;
  const auto state = node.get<std::vector<double>>("initial_state");
  if (!state.empty() && state.size() != kStates) {
    return err(wrong("initial_state", fmt::format("has {} numbers", state.size()), "give 15"));
  }
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (!std::isfinite(state[i]))
      return err(wrong("initial_state", fmt::format("number {} is not finite", i), "give 15 numbers"));
    const bool angle = i >= kRoll && i <= kYaw;
    filter.initial.mean[static_cast<int>(i)] = angle ? spatial::wrap_to_pi(state[i]) : state[i];
  }
  const std::int64_t limit = node.get<std::int64_t>("measurement_queue_limit");
  if (limit < 16 || limit > 65536)
    return err(wrong("measurement_queue_limit", fmt::format("is {}", limit), "give 16 to 65536"));
  filter.queue_limit = static_cast<std::size_t>(limit);
  filter.period = from_seconds(1.0 / options.frequency_hz);
  filter.two_d_mode = node.get<bool>("two_d_mode");
  filter.predict_to_current_time = node.get<bool>("predict_to_current_time");
  filter.dynamic_process_noise = node.get<bool>("dynamic_process_noise_covariance");
  const auto timeout_s = node.get<double>("sensor_timeout");
  if (!(timeout_s > 0.0) || !(timeout_s < 1e6))
    return err(wrong("sensor_timeout", fmt::format("is {}", timeout_s), "give seconds, more than 0"));
  filter.sensor_timeout = from_seconds(timeout_s);
  filter.timeout_from_stamp = node.get<bool>("sensor_timeout_from_stamp");
  return {};
}

// robot_localization's tf_prefix, which puts a slash behind it; then ours, which does not.
std::string frame_of(const Node& node, const std::string& parameter) {
  const auto without_slash = [](std::string name) { return name.starts_with('/') ? name.substr(1) : name; };
  const std::string prefix = without_slash(node.get<std::string>("tf_prefix"));
  const auto frame = node.get<std::string>(parameter);
  if (prefix.empty() || frame.empty()) return frame_name(node, parameter);
  return with_frame_prefix(node.get<std::string>(kFramePrefixParameter), prefix + "/" + without_slash(frame));
}

Result<void, Problem> read_frames(const Node& node, EkfOptions& options) {
  options.map_frame = frame_of(node, "map_frame");
  options.odom_frame = frame_of(node, "odom_frame");
  options.base_link_frame = frame_of(node, "base_link_frame");
  options.world_frame = frame_of(node, "world_frame");
  options.base_link_frame_output = options.base_link_frame;
  if (!node.get<std::string>("base_link_frame_output").empty())
    options.base_link_frame_output = frame_of(node, "base_link_frame_output");
  if (options.world_frame != options.map_frame && options.world_frame != options.odom_frame) {
    return err(wrong("world_frame",
                     fmt::format("'{}' is neither map_frame ('{}') nor odom_frame ('{}')", options.world_frame,
                                 options.map_frame, options.odom_frame),
                     "give one of them"));
  }
  if (options.base_link_frame.empty() || options.odom_frame.empty() || options.world_frame.empty()) {
    return err(wrong("base_link_frame", "a frame has no name", "set map_frame, odom_frame and base_link_frame"));
  }
  for (const auto& [parameter, frame] : {std::pair{"base_link_frame", options.base_link_frame},
                                         std::pair{"base_link_frame_output", options.base_link_frame_output}}) {
    if (frame == options.odom_frame || frame == options.map_frame)
      return err(wrong(parameter, fmt::format("'{}' is a world frame, too", frame), "give three names"));
  }
  return {};
}

constexpr const char* kSixAxes = "give 6: vx vy vz, vroll vpitch vyaw";

// Nothing given means `otherwise`.
Result<ControlOptions::Axes, Problem> read_axes(const Node& node, const char* name,
                                                const ControlOptions::Axes& otherwise) {
  const auto given = node.get<std::vector<double>>(name);
  if (given.empty()) return otherwise;
  if (given.size() != ControlOptions::kAxes)
    return err(wrong(name, fmt::format("has {} numbers", given.size()), kSixAxes));
  ControlOptions::Axes axes{};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!(given[i] >= 0.0) || !std::isfinite(given[i]))
      return err(wrong(name, fmt::format("number {} is {}", i, given[i]), "give 0 or more"));
    axes[i] = given[i];
  }
  return axes;
}

// After the inputs: an acceleration that is measured is not commanded. Source: robot_localization, RosFilter::loadParams.
Result<void, Problem> read_control(const Node& node, EkfOptions& options) {
  options.stamped_control = node.get<bool>("stamped_control");
  if (!node.get<bool>("use_control")) return {};
  ControlOptions control;
  const auto config = node.get<std::vector<bool>>("control_config");
  if (!config.empty() && config.size() != ControlOptions::kAxes)
    return err(wrong("control_config", fmt::format("has {} booleans", config.size()), kSixAxes));
  std::copy(config.begin(), config.end(), control.controlled.begin());
  const double timeout_s = node.get<double>("control_timeout");
  if (!(timeout_s >= 0.0) || !(timeout_s < 1e6))
    return err(wrong("control_timeout", fmt::format("is {}", timeout_s), "give seconds, 0 or more"));
  control.timeout = from_seconds(timeout_s);
  const auto read = [&](const char* name, const ControlOptions::Axes& otherwise,
                        ControlOptions::Axes& into) -> Result<void, Problem> {
    const auto axes = read_axes(node, name, otherwise);
    if (!axes) return err(axes.error());
    into = *axes;
    return {};
  };
  const ControlOptions plain;
  if (const auto r = read("acceleration_limits", plain.acceleration_limits, control.acceleration_limits); !r)
    return err(r.error());
  if (const auto r = read("acceleration_gains", plain.acceleration_gains, control.acceleration_gains); !r)
    return err(r.error());
  if (const auto r = read("deceleration_limits", control.acceleration_limits, control.deceleration_limits); !r)
    return err(r.error());
  if (const auto r = read("deceleration_gains", control.acceleration_gains, control.deceleration_gains); !r)
    return err(r.error());
  for (const InputOptions& input : options.inputs) {
    for (int i = 0; input.kind == InputKind::Imu && i < 3; ++i) {
      bool& controlled = control.controlled[static_cast<std::size_t>(i)];
      if (!has(input.config, kAx + i) || !controlled) continue;
      controlled = false;
      options.notes.push_back(fmt::format("use_control: {} measures {}, so that the command for {} is not used",
                                          input.name, kStateNames[static_cast<std::size_t>(kAx + i)],
                                          kStateNames[static_cast<std::size_t>(kVx + i)]));
    }
  }
  if (!control.any()) options.notes.emplace_back("use_control: control_config is true for nothing: no command is used");
  if (control.any() && control.timeout == 0ns)
    options.notes.emplace_back("use_control: control_timeout is 0: every command counts as zero at once");
  options.filter.control = control;
  return {};
}

}  // namespace

Result<EkfOptions, Problem> read_ekf_parameters(const Node& node) {
  EkfOptions options;
  options.frequency_hz = node.get<double>("frequency");
  if (!(options.frequency_hz > 0.0) || options.frequency_hz > 10000.0) {
    return err(
        wrong("frequency", fmt::format("is {}", options.frequency_hz), "give Hz, more than 0 and at most 10000"));
  }
  if (const auto read = read_filter(node, options); !read) return err(read.error());
  if (const auto read = read_frames(node, options); !read) return err(read.error());
  options.publish_tf = node.get<bool>("publish_tf");
  options.publish_acceleration = node.get<bool>("publish_acceleration");
  options.print_diagnostics = node.get<bool>("print_diagnostics");
  options.disabled_at_startup = node.get<bool>("disabled_at_startup");
  options.gravity_mps2 = node.get<double>("gravitational_acceleration");
  options.debug = node.get<bool>("debug");
  if (options.debug)
    options.debug_out_file =
        DebugFile::path_for(node.get<std::string>("debug_out_file"), node.get_fully_qualified_name());
  options.robot_localization_rotations = node.get<bool>("robot_localization_rotations");
  const double offset_s = node.get<double>("transform_time_offset");
  if (!(std::abs(offset_s) <= 3600.0))
    return err(wrong("transform_time_offset", fmt::format("is {}", offset_s), "give seconds"));
  options.transform_time_offset = from_seconds(offset_s);
  if (const auto behind = inputs_behind_a_gap(node); !behind.empty()) {
    return err(wrong(behind.front(), "comes after a gap in the numbering", "number the inputs of a kind 0, 1, 2 ..."));
  }
  for (const NamedInput& named : named_inputs(node)) {
    auto input = read_input(node, named);
    if (!input) return err(input.error());
    if (input->config == 0)
      options.notes.push_back(fmt::format("{}_config is all false: nothing of {} is fused", input->name, input->topic));
    if (input->config != 0 && options.filter.two_d_mode && (input->config & ~kFlatStates) == 0)
      options.notes.push_back(
          fmt::format("{}_config names only what two_d_mode holds at zero: {} tells the filter nothing", input->name,
                      input->topic));
    if (input->differential && input->relative)
      options.notes.push_back(fmt::format("{} is differential; relative is ignored", input->name));
    options.inputs.push_back(std::move(input).value());
  }
  if (const auto read = read_control(node, options); !read) return err(read.error());
  if (const auto read = read_history(node, options); !read) return err(read.error());
  if (const auto read = read_wheeled_noise(node, options); !read) return err(read.error());
  if (const auto read = read_assists(node, options); !read) return err(read.error());
  return options;
}

}  // namespace nacelle::ekf
