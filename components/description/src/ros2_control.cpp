// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/ros2_control.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

#include "nacelle/base/xml.hpp"

namespace nacelle::description {
namespace {

using tinyxml2::XMLElement;

const std::vector<std::string> kTypes{"system", "actuator", "sensor"};
const std::vector<std::string> kInterfaces{"position", "velocity", "acceleration", "effort",
                                           "torque",   "force",    "current",      "temperature"};
// The known child elements of each element. Other elements are not checked below.
const std::map<std::string_view, std::vector<std::string>> kTags{
    {"ros2_control", {"hardware", "joint", "sensor", "gpio", "transmission"}},
    {"hardware", {"plugin", "param", "group", "properties"}},
    {"joint", {"command_interface", "state_interface", "param", "plugin"}},
    {"command_interface", {"param", "limits"}},
    {"state_interface", {"param", "limits"}}};

std::string text_in(const XMLElement& element) {
  const char* const text = element.GetText();
  if (text == nullptr) return {};
  const std::string_view all{text};
  const auto first = all.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return std::string{all.substr(first, all.find_last_not_of(" \t\r\n") - first + 1)};
}

std::string attribute(const XMLElement& element, const char* name) {
  const char* const value = element.Attribute(name);
  return value == nullptr ? std::string{} : value;
}

std::array<double, 3> three_numbers(const std::string& text) {
  std::array<double, 3> numbers{};
  const char* at = text.c_str();
  for (double& number : numbers) {
    char* end = nullptr;
    number = std::strtod(at, &end);
    at = end;
  }
  return numbers;  // the reader of the tree checks whether they are numbers
}

class Reader {
 public:
  explicit Reader(const RobotDescription& description) : description_(description) {}

  ControlDescription read(const XMLElement& root) {
    number_all(root);
    for (const auto* child = root.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      const std::string_view tag = child->Name();
      if (tag == "joint") result_.joints.push_back(robot_joint(*child));
      if (tag == "link") read_radius(*child);
      if (tag == "ros2_control") blocks_.push_back(child);
    }
    for (const auto& joint : result_.joints) {
      names_.push_back(joint.name);
      by_name_.emplace(joint.name, &joint);
    }
    for (const XMLElement* const block : blocks_) result_.blocks.push_back(read_block(*block));
    for (const ControlBlock& block : result_.blocks) check(block);
    return std::move(result_);
  }

 private:
  // In document order, as the places of a xacro file are.
  void number_all(const XMLElement& element) {
    numbers_.emplace(&element, numbers_.size());
    for (const auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement())
      number_all(*child);
  }
  [[nodiscard]] Place place(const XMLElement& element) const {
    return description_.place(numbers_.at(&element), element.GetLineNum());
  }
  void error(Place where, std::string what, std::string way_out) {
    constexpr std::size_t kMostErrors = 100;
    if (result_.errors.size() >= kMostErrors) return;
    result_.errors.push_back({std::move(where), std::move(what), std::move(way_out)});
  }

  RobotJoint robot_joint(const XMLElement& element) {
    RobotJoint joint{.name = attribute(element, "name"),
                     .type = attribute(element, "type"),
                     .where = place(element),
                     .parent = {},
                     .child = {}};
    if (const auto* parent = element.FirstChildElement("parent")) joint.parent = attribute(*parent, "link");
    if (const auto* child = element.FirstChildElement("child")) joint.child = attribute(*child, "link");
    if (const auto* origin = element.FirstChildElement("origin")) {
      joint.xyz_m = three_numbers(attribute(*origin, "xyz"));
      joint.rpy_rad = three_numbers(attribute(*origin, "rpy"));
    }
    return joint;
  }

  void read_radius(const XMLElement& link) {
    for (const char* const part : {"collision", "visual"}) {
      const XMLElement* const body = link.FirstChildElement(part);
      const XMLElement* const geometry = body == nullptr ? nullptr : body->FirstChildElement("geometry");
      if (geometry == nullptr) continue;
      for (const char* const shape : {"cylinder", "sphere"}) {
        const XMLElement* const round = geometry->FirstChildElement(shape);
        double radius_m = 0;
        if (round == nullptr || round->QueryDoubleAttribute("radius", &radius_m) != tinyxml2::XML_SUCCESS) continue;
        if (std::isfinite(radius_m) && radius_m > 0) result_.radii_m.emplace(attribute(link, "name"), radius_m);
        return;
      }
    }
  }

  void warn_of_strangers(const XMLElement& element) {
    const std::vector<std::string>& known = kTags.at(element.Name());
    for (const auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      const std::string tag = child->Name();
      if (std::ranges::find(known, tag) != known.end()) continue;
      const std::string way_out = tag == "controller"
                                      ? "a controller's parameters belong into the parameter file: `nacelle import`"
                                      : suggestion(tag, known);
      result_.warnings.push_back(
          {place(*child),
           fmt::format("<{}> is not a tag of ros2_control inside <{}>, and is ignored", tag, element.Name()), way_out});
    }
  }

  std::string required_name(const XMLElement& element) {
    std::string name = attribute(element, "name");
    if (name.empty()) error(place(element), fmt::format("<{}> has no name", element.Name()), "add name=\"...\"");
    return name;
  }

  ControlBlock read_block(const XMLElement& element) {
    warn_of_strangers(element);
    ControlBlock block{.name = required_name(element),
                       .type = attribute(element, "type"),
                       .where = place(element),
                       .plugin = {},
                       .plugin_where = {},
                       .params = {},
                       .joints = {}};
    if (std::ranges::find(kTypes, block.type) == kTypes.end())
      error(block.where, fmt::format("'{}' is not a type of hardware", block.type), suggestion(block.type, kTypes));
    if (const auto* hardware = element.FirstChildElement("hardware")) read_hardware(*hardware, block);
    if (block.plugin.empty())
      error(block.where, fmt::format("<ros2_control name=\"{}\"> names no hardware plugin", block.name),
            "add <hardware><plugin>nacelle/waveshare</plugin></hardware>");
    for (const auto* joint = element.FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint"))
      block.joints.push_back(read_joint(*joint));
    return block;
  }

  void read_hardware(const XMLElement& element, ControlBlock& block) {
    warn_of_strangers(element);
    if (const auto* plugin = element.FirstChildElement("plugin")) {
      block.plugin = text_in(*plugin);
      block.plugin_where = place(*plugin);
    }
    for (const auto* param = element.FirstChildElement("param"); param; param = param->NextSiblingElement("param"))
      block.params.push_back({required_name(*param), text_in(*param), place(*param)});
  }

  ControlJoint read_joint(const XMLElement& element) {
    warn_of_strangers(element);
    ControlJoint joint{required_name(element), place(element), {}, {}};
    for (const auto& [tag, into] :
         {std::pair{"command_interface", &joint.commands}, {"state_interface", &joint.states}}) {
      for (const auto* child = element.FirstChildElement(tag); child; child = child->NextSiblingElement(tag)) {
        warn_of_strangers(*child);
        ControlInterface interface { required_name(*child), place(*child) };
        if (std::ranges::find(*into, interface.name, &ControlInterface::name) != into->end())
          error(interface.where, fmt::format("joint '{}' has the {} '{}' twice", joint.name, tag, interface.name),
                "take one of them out");
        check_name(interface);
        into->push_back(std::move(interface));
      }
    }
    return joint;
  }

  // Names of one's own are allowed; one that is nearly a usual name is a slip of the pen.
  void check_name(const ControlInterface& interface) {
    if (interface.name.empty() || std::ranges::find(kInterfaces, interface.name) != kInterfaces.end()) return;
    if (const auto near = nearest_name(interface.name, kInterfaces); !near.empty())
      error(interface.where, fmt::format("'{}' is not an interface", interface.name), "did you mean '" + near + "'?");
  }

  void check(const ControlBlock& block) {
    std::set<std::string_view> seen;
    for (const ControlJoint& joint : block.joints) {
      if (joint.name.empty()) continue;
      if (!seen.insert(joint.name).second)
        error(joint.where, fmt::format("joint '{}' is twice in this block", joint.name), "take one of them out");
      const auto real = by_name_.find(joint.name);
      if (real == by_name_.end()) {
        error(joint.where, fmt::format("the robot has no joint '{}'", joint.name), suggestion(joint.name, names_));
      } else if (real->second->type == "fixed" && !joint.commands.empty()) {
        error(joint.where,
              fmt::format("joint '{}' is fixed ({}), and cannot be commanded", joint.name, real->second->where.text()),
              "give it another type, or take its command interfaces out");
      }
    }
  }

  const RobotDescription& description_;
  std::map<const XMLElement*, std::size_t> numbers_;
  std::vector<const XMLElement*> blocks_;
  ControlDescription result_;
  std::vector<std::string> names_;  // of the robot's joints, which stay where they are from then on
  std::map<std::string_view, const RobotJoint*> by_name_;
};

std::array<double, 3> turned(const std::array<double, 3>& p, const std::array<double, 3>& rpy_rad) {
  const auto [roll, pitch, yaw] = std::tuple{rpy_rad[0], rpy_rad[1], rpy_rad[2]};
  std::array<double, 3> q{p[0], p[1] * std::cos(roll) - p[2] * std::sin(roll),
                          p[1] * std::sin(roll) + p[2] * std::cos(roll)};
  q = {q[0] * std::cos(pitch) + q[2] * std::sin(pitch), q[1], -q[0] * std::sin(pitch) + q[2] * std::cos(pitch)};
  return {q[0] * std::cos(yaw) - q[1] * std::sin(yaw), q[0] * std::sin(yaw) + q[1] * std::cos(yaw), q[2]};
}

}  // namespace

bool ControlJoint::has_command(const std::string& wanted) const {
  return std::ranges::find(commands, wanted, &ControlInterface::name) != commands.end();
}

const RobotJoint* ControlDescription::joint(const std::string& name) const {
  const auto found = std::ranges::find(joints, name, &RobotJoint::name);
  return found == joints.end() ? nullptr : &*found;
}

const ControlJoint* ControlDescription::controlled(const std::string& name) const {
  for (const auto& block : blocks) {
    const auto found = std::ranges::find(block.joints, name, &ControlJoint::name);
    if (found != block.joints.end()) return &*found;
  }
  return nullptr;
}

std::optional<double> ControlDescription::y_of(const RobotJoint& wanted) const {
  std::map<std::string_view, const RobotJoint*> by_child;
  for (const auto& joint : joints) by_child.emplace(joint.child, &joint);
  std::array<double, 3> p = wanted.xyz_m;
  const RobotJoint* at = &wanted;
  for (std::size_t hops = 0; hops <= joints.size(); ++hops) {
    const auto above = by_child.find(at->parent);
    if (above == by_child.end()) return p[1];
    at = above->second;
    p = turned(p, at->rpy_rad);
    for (std::size_t i = 0; i < 3; ++i) p[i] += at->xyz_m[i];
  }
  return std::nullopt;
}

ControlDescription read_ros2_control(const RobotDescription& description) {
  tinyxml2::XMLDocument document;
  if (!parse_xml(document, description.urdf, description.file)) return {};
  return Reader{description}.read(*document.RootElement());
}

Result<Wheels, Problem> wheels_of(const ControlDescription& description) {
  constexpr double kMiddle_m = 1e-6;
  Wheels wheels;
  for (const ControlBlock& block : description.blocks) {
    for (const ControlJoint& joint : block.joints) {
      const RobotJoint* const real = description.joint(joint.name);
      if (real == nullptr || real->type != "continuous" || !joint.has_command("velocity")) continue;
      const double y_m = description.y_of(*real).value_or(0.0);
      const bool says_left = joint.name.find("left") != std::string::npos;
      const bool says_right = joint.name.find("right") != std::string::npos;
      if (std::abs(y_m) < kMiddle_m && says_left == says_right)
        return err(Problem{joint.where,
                           fmt::format("joint '{}' may be a wheel of the left or of the right: its y is 0", joint.name),
                           "set left_wheel_names and right_wheel_names"});
      const bool left = std::abs(y_m) < kMiddle_m ? says_left : y_m > 0;
      (left ? wheels.left : wheels.right).push_back(joint.name);
    }
  }
  return wheels;
}

WheelLengths wheel_lengths_of(const ControlDescription& description, const Wheels& wheels) {
  WheelLengths lengths;
  std::vector<std::string> all = wheels.left;
  all.insert(all.end(), wheels.right.begin(), wheels.right.end());
  const auto is_wheel = [&](const ControlJoint& joint) { return std::ranges::find(all, joint.name) != all.end(); };
  for (const ControlBlock& block : description.blocks) {
    if (!std::ranges::any_of(block.joints, is_wheel)) continue;
    for (const ControlParam& param : block.params) {
      char* end = nullptr;
      const double value_m = std::strtod(param.value.c_str(), &end);
      if (param.value.empty() || *end != '\0' || !std::isfinite(value_m) || value_m <= 0) continue;
      if (param.name == "wheel_separation") lengths.separation_m = value_m;
      if (param.name == "wheel_radius") lengths.radius_m = value_m;
    }
  }
  const auto mean_y = [&](const std::vector<std::string>& names) -> std::optional<double> {
    double sum_m = 0;
    for (const auto& name : names) {
      const RobotJoint* const joint = description.joint(name);
      const auto y_m = joint == nullptr ? std::nullopt : description.y_of(*joint);
      if (!y_m) return std::nullopt;
      sum_m += *y_m;
    }
    return names.empty() ? std::nullopt : std::optional{sum_m / static_cast<double>(names.size())};
  };
  const auto left_m = mean_y(wheels.left), right_m = mean_y(wheels.right);
  constexpr double kLeast_m = 1e-3;  // joints without places stand in one point
  if (!lengths.separation_m && left_m && right_m && *left_m - *right_m > kLeast_m)
    lengths.separation_m = *left_m - *right_m;
  std::optional<double> radius_m;
  for (const auto& name : all) {
    const RobotJoint* const joint = description.joint(name);
    const auto found = joint == nullptr ? description.radii_m.end() : description.radii_m.find(joint->child);
    if (found == description.radii_m.end() || (radius_m && *radius_m != found->second)) return lengths;
    radius_m = found->second;
  }
  if (!lengths.radius_m) lengths.radius_m = radius_m;
  return lengths;
}

}  // namespace nacelle::description
