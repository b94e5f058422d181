// SPDX-License-Identifier: Apache-2.0
// The device's controls as parameters: a part of CameraComponent.
#include <fmt/format.h>

#include <algorithm>

#include "camera/component/camera_component.hpp"
#include "camera/port/camera_fault.hpp"

namespace nacelle::camera {
namespace {

std::int64_t number_of(const ParameterValue& value) {
  const bool* const yes = std::get_if<bool>(&value);
  return yes != nullptr ? std::int64_t{*yes} : std::get<std::int64_t>(value);
}

}  // namespace

// Which controls there are is known when the device is open, long after parameters are declared. A number or a switch
// that is no parameter of ours is therefore taken for a control now and looked for then.
void CameraComponent::declare_control_overrides() {
  for (const std::string& name : parameters().unused_overrides()) {
    const ParameterType type = type_of(parameters().overrides().at(name));
    if (type != ParameterType::Integer && type != ParameterType::Bool) continue;
    // Similar to a parameter's name: no control has such a name, so the check of parameters should report it.
    if (!nearest_name(name, parameters().list()).empty()) continue;
    declare_parameter(
        name, type,
        {"A control of the camera, if it has one of that name.", "", false, true, std::nullopt, std::nullopt});
    given_controls_.push_back(name);
  }
}

void CameraComponent::declare_controls(std::vector<Control> controls) {
  controls_ = std::move(controls);
  std::vector<std::string> names;
  for (const Control& control : controls_) {
    names.push_back(control.name);
    if (has_parameter(control.name)) continue;
    ParameterDescriptor descriptor{fmt::format("Control of the camera, {} to {}.", control.least, control.most), "",
                                   control.read_only};
    if (control.is_switch) {
      declare_parameter<bool>(control.name, control.value != 0, std::move(descriptor));
    } else {
      // The range is the driver's to judge: a current value outside of it must not end the configuration.
      declare_parameter<std::int64_t>(control.name, control.value, std::move(descriptor));
    }
    found_controls_.push_back(control.name);
  }
  for (const std::string& name : given_controls_) {
    const auto found =
        std::find_if(controls_.begin(), controls_.end(), [&](const Control& control) { return control.name == name; });
    if (found != controls_.end()) {
      chosen_.lock()->emplace_back(*found, number_of(parameters().get(name)));
    } else {
      get_logger().warn("parameter {}: {} has no such control; {}", name, loop_->format().camera_name,
                        names.empty() ? "it has none" : suggestion(name, names));
    }
  }
  apply_controls();
}

void CameraComponent::undeclare_controls() {
  for (const std::string& name : found_controls_) parameters().undeclare(name);
  found_controls_.clear();
  controls_.clear();
  chosen_.lock()->clear();
}

void CameraComponent::apply_controls() {
  const auto chosen = *chosen_.lock();
  for (const auto& [control, value] : chosen) {
    if (const auto set = port_->set_control(control, value); !set)
      get_logger().warn("parameter {}: {}", control.name, set.error().text());
  }
}

SetParametersResult CameraComponent::set_controls(const std::vector<Parameter>& parameters) {
  for (const Parameter& parameter : parameters) {
    const auto found = std::find_if(controls_.begin(), controls_.end(),
                                    [&](const auto& control) { return control.name == parameter.get_name(); });
    if (found == controls_.end()) continue;
    const ParameterType type = parameter.get_type();
    if (type != ParameterType::Integer && type != ParameterType::Bool)
      return {false, fmt::format("control {} is a number", found->name)};
    const std::int64_t value = number_of(parameter.get_parameter_value());
    if (!found->is_switch && (value < found->least || value > found->most))  // some drivers clamp without a word
      return {false, fmt::format("{} is out of the control's range, {} to {}", value, found->least, found->most)};
    if (loop_ && loop_->is_open()) {
      const auto set = port_->set_control(*found, value);
      // A device that was lost meanwhile gets the value when it is open again.
      if (!set && set.error().code != CameraFault::NotOpen) return {false, set.error().text()};
    }
    auto chosen = chosen_.lock();
    const auto earlier =
        std::find_if(chosen->begin(), chosen->end(), [&](const auto& entry) { return entry.first.id == found->id; });
    if (earlier == chosen->end()) {
      chosen->emplace_back(*found, value);
    } else {
      earlier->second = value;
    }
  }
  return {};
}

}  // namespace nacelle::camera
