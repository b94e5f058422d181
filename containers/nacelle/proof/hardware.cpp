// SPDX-License-Identifier: Apache-2.0
// Rules about the robot itself: devices that two components open, wheels that two components measure differently.
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proof/rules.hpp"

namespace nacelle::proof {
namespace {

/// The device behind a path; names below /dev/serial/by-id lead to the same one.
std::string device_behind(const std::string& path) {
  std::error_code ignored;
  const auto device = std::filesystem::weakly_canonical(path, ignored);
  return ignored || device.empty() ? path : device.string();
}

template <typename T>
std::optional<T> value_of(const LoadedComponent& component, std::string_view parameter) {
  if (!component.declared) return std::nullopt;
  // A refused value has its own finding.
  if (component.has_fault_of(parameter)) return std::nullopt;
  for (const auto& declared : component.declared->parameters) {
    if (declared.name != parameter) continue;
    const auto* const value = std::get_if<T>(&declared.value);
    return value == nullptr ? std::nullopt : std::optional{*value};
  }
  return std::nullopt;
}

/// Returns whether the reader, in the base's process, takes the parameter from the base because it is not set.
bool takes_from_base(const LoadedComponent& base, const LoadedComponent& reader, std::string_view parameter) {
  using launch::Isolation;
  if (reader.plan->isolate != Isolation::None || base.plan->isolate != Isolation::None) return false;
  return std::ranges::none_of(reader.plan->parameters, [&](const auto& given) { return given.name == parameter; });
}

/// The topic of joint states by which `reader` follows `writer`; empty: it does not.
std::string joint_states_between(const Evidence& evidence, const std::string& writer, const std::string& reader) {
  for (const Endpoint& from : evidence.endpoints) {
    if (!from.publishes || from.node != writer || from.type != "sensor_msgs/msg/JointState") continue;
    for (const Endpoint& to : evidence.endpoints) {
      if (!to.publishes && to.node == reader && to.topic == from.topic) return from.topic;
    }
  }
  return {};
}

/// A length of the wheels, and the parameter that corrects it in one component only.
struct WheelLength {
  const char *parameter, *calibration;
};
constexpr std::array kWheelLengths{WheelLength{"wheel_separation", "wheel_separation_multiplier"},
                                   WheelLength{"wheel_radius", "left_ and right_wheel_radius_multiplier"}};

void compare_wheels(const LoadedComponent& base, const LoadedComponent& reader, Evidence& evidence) {
  const std::string base_node = base.plan->full_name(), node = reader.plan->full_name();
  for (const WheelLength& length : kWheelLengths) {
    const auto driven = value_of<double>(base, length.parameter), measured = value_of<double>(reader, length.parameter);
    if (takes_from_base(base, reader, length.parameter)) continue;
    if (!driven || !measured || std::abs(*driven - *measured) <= 1e-9 * std::abs(*driven)) continue;
    const std::string topic = joint_states_between(evidence, base_node, node);
    if (topic.empty()) continue;
    evidence.find(Rule::WheelsDiffer,
                  {place_of_parameter(*reader.plan, length.parameter),
                   fmt::format("{} is {} in {} and {} in {} ({}), which measures the same wheels on '{}'",
                               length.parameter, *measured, node, *driven, base_node,
                               place_of_parameter(*base.plan, length.parameter).text(), topic),
                   fmt::format("give both the same value; a correction belongs in {}", length.calibration)},
                  severity_of(evidence.plan, {base_node, node}));
  }
}

/// Joints that the reader waits for, and that the only writer of its joint states does not have.
void compare_names(const LoadedComponent& base, const LoadedComponent& reader, Evidence& evidence) {
  using Names = std::vector<std::string>;
  const std::string base_node = base.plan->full_name(), node = reader.plan->full_name();
  for (const char* const parameter : {"left_wheel_names", "right_wheel_names"}) {
    if (takes_from_base(base, reader, parameter)) continue;
    const auto driven = value_of<Names>(base, parameter), awaited = value_of<Names>(reader, parameter);
    if (!driven || !awaited) continue;
    const auto absent = std::ranges::find_if(
        *awaited, [&](const std::string& name) { return std::ranges::find(*driven, name) == driven->end(); });
    const std::string topic = joint_states_between(evidence, base_node, node);
    if (absent == awaited->end() || topic.empty()) continue;
    const auto others = [&](const Endpoint& end) {
      return end.publishes && end.topic == topic && end.node != base_node;
    };
    if (std::ranges::any_of(evidence.endpoints, others)) continue;
    evidence.find(Rule::WheelsDiffer,
                  {place_of_parameter(*reader.plan, parameter),
                   fmt::format("{} of {} has the joint '{}', but {} ({}), which alone publishes '{}', has '{}'",
                               parameter, node, *absent, base_node, place_of_parameter(*base.plan, parameter).text(),
                               topic, fmt::join(*driven, "', '")),
                   "give both the same names; without its joints there is no odometry"},
                  severity_of(evidence.plan, {base_node, node}));
  }
}

}  // namespace

void check_devices(Evidence& evidence) {
  struct Opener {
    const LoadedComponent* component;
    const DeviceUse* use;
  };
  std::map<std::string, Opener> openers;
  for (const LoadedComponent& component : evidence.loaded) {
    if (!component.declared) continue;
    for (const DeviceUse& use : component.declared->device_uses) {
      if (!use.path.starts_with('/')) continue;
      const auto [first, is_new] = openers.emplace(device_behind(use.path), Opener{&component, &use});
      if (is_new) continue;
      const launch::ComponentPlan &plan = *component.plan, &other = *first->second.component->plan;
      const DeviceUse& others = *first->second.use;
      evidence.find(Rule::DeviceTwice,
                    {place_of_parameter(plan, use.parameter),
                     fmt::format("{} (parameter {}) opens the device '{}', which {} (parameter {}, {}) opens, too{}",
                                 plan.full_name(), use.parameter, use.path, other.full_name(), others.parameter,
                                 place_of_parameter(other, others.parameter).text(),
                                 others.path == use.path ? "" : " as '" + others.path + "'"),
                     "give each its own device; `ls -l /dev/serial/by-id` shows what is plugged in"},
                    severity_of(evidence.plan, {plan.full_name(), other.full_name()}));
    }
  }
}

void check_wheels(Evidence& evidence) {
  for (const LoadedComponent& base : evidence.loaded) {
    for (const LoadedComponent& reader : evidence.loaded) {
      if (&base == &reader) continue;
      compare_names(base, reader, evidence);
      compare_wheels(base, reader, evidence);
    }
  }
}

}  // namespace nacelle::proof
