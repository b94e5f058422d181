// SPDX-License-Identifier: Apache-2.0
// A rule about GPS: positions on the Earth become positions in the robot's world only with a heading.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "proof/rules.hpp"

namespace nacelle::proof {
namespace {

constexpr const char* kImu = "sensor_msgs/msg/Imu";
constexpr const char* kWayOut =
    "remap imu to a topic that has an orientation from a magnetometer (imu/data), or set wait_for_datum: true with a "
    "datum, or use_odometry_yaw: true if the odometry's heading counts from east";

std::optional<bool> switch_of(const LoadedComponent& component, std::string_view parameter) {
  if (!component.declared) return std::nullopt;
  for (const auto& declared : component.declared->parameters) {
    if (declared.name != parameter) continue;
    const auto* const value = std::get_if<bool>(&declared.value);
    return value == nullptr ? std::nullopt : std::optional{*value};
  }
  return std::nullopt;
}

const LoadedComponent* component_of(const Evidence& evidence, const std::string& node) {
  const auto found =
      std::ranges::find(evidence.loaded, node, [](const auto& component) { return component.plan->full_name(); });
  return found == evidence.loaded.end() ? nullptr : &*found;
}

/// Why no heading comes from there; empty: one does, as far as a plan can tell.
std::string lack_of(const Evidence& evidence, const Endpoint& writer) {
  // REP 145: data_raw is what the sensors measured, without an orientation.
  if (writer.topic.ends_with("data_raw")) return "has no orientation (REP 145)";
  const LoadedComponent* const component = component_of(evidence, writer.node);
  if (component != nullptr && switch_of(*component, "use_mag") == false)
    return "has an orientation whose heading is unknown, since use_mag of " + writer.node + " is false";
  return {};
}

void check_heading(const LoadedComponent& component, const Endpoint& reader, Evidence& evidence) {
  std::vector<const Endpoint*> writers;
  bool has_other_imu = false;
  for (const Endpoint& end : evidence.endpoints) {
    if (!end.publishes || end.type != kImu) continue;
    if (end.topic == reader.topic) writers.push_back(&end);
    has_other_imu |= end.topic != reader.topic;
  }
  const auto report = [&](const std::string& why, Severity severity) {
    evidence.find(Rule::NoHeading,
                  {component.plan->where, fmt::format("{} has no heading: {}", reader.node, why), kWayOut}, severity);
  };
  if (writers.empty()) {
    // An IMU that the plan has was meant; without one, another container may publish the topic.
    report(fmt::format("its input '{}' is published by no component", reader.topic),
           has_other_imu ? severity_of(*component.plan) : Severity::Warning);
    return;
  }
  for (const Endpoint* const writer : writers) {
    const std::string lack = lack_of(evidence, *writer);
    if (lack.empty()) return;
    if (writer == writers.back()) report(fmt::format("'{}' {}", reader.topic, lack), severity_of(*component.plan));
  }
}

}  // namespace

void check_headings(Evidence& evidence) {
  for (const LoadedComponent& component : evidence.loaded) {
    // Those of robot_localization's navsat_transform_node: with either switch it does not use an IMU.
    if (switch_of(component, "wait_for_datum") != false || switch_of(component, "use_odometry_yaw") != false) continue;
    const std::string node = component.plan->full_name();
    const auto reads_imu = [&](const Endpoint& end) { return !end.publishes && end.node == node && end.type == kImu; };
    const auto reader = std::ranges::find_if(evidence.endpoints, reads_imu);
    if (reader != evidence.endpoints.end()) check_heading(component, *reader, evidence);
  }
}

}  // namespace nacelle::proof
