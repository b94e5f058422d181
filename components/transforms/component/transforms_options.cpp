// SPDX-License-Identifier: Apache-2.0
#include "transforms/component/transforms_options.hpp"

#include <fmt/format.h>

#include <map>

#include "nacelle/description/robot_description.hpp"
#include "nacelle/node/frame_name.hpp"

namespace nacelle::transforms {
namespace {

// A frame has one parent, whether the description or the parameter says so.
Result<void, Problem> check_parents(const TransformsOptions& options) {
  std::map<std::string, std::string> parents;
  for (const Joint& joint : options.tree.joints) parents[joint.child] = joint.parent;
  for (const StaticTransform& transform : options.static_transforms) {
    const auto [known, added] = parents.emplace(transform.child, transform.parent);
    if (!added) {
      return err(Problem{
          Place::of_parameter("static_transforms"),
          fmt::format("frame '{}' has two parents, '{}' and '{}'", transform.child, known->second, transform.parent),
          "leave one of them out"});
    }
  }
  return {};
}

}  // namespace

void declare_transforms_parameters(Node& node) {
  const auto say = [](const char* text) { return ParameterDescriptor{.description = text, .read_only = true}; };
  node.declare_parameter("robot_description", "", say("The robot as URDF text; published on robot_description."));
  node.declare_parameter("robot_description_file", "", say("A file that holds it, instead: URDF, or xacro (*.xacro)."));
  node.declare_parameter("xacro_arguments", std::vector<std::string>{},
                         say("What the xacro file's arguments are, each \"name:=value\"."));
  node.declare_parameter(
      "static_transforms", std::vector<std::string>{},
      say("More fixed transforms: \"x y z yaw pitch roll parent child\" or \"x y z qx qy qz qw parent child\"."));
  ParameterDescriptor frequency = say("Most transforms per second and movable joint, Hz; 0 is none.");
  frequency.floating_point_range = FloatingPointRange{0.0, 1000.0, 0.0};
  node.declare_parameter("publish_frequency", 30.0, frequency);
  declare_frame_prefix(node);
  node.declare_parameter("ignore_timestamp", false, say("Publish for every joint state, whatever its stamp."));
}

Result<TransformsOptions, Problem> read_transforms_parameters(const Node& node) {
  TransformsOptions options;
  options.description = node.get<std::string>("robot_description");
  const auto file = node.get<std::string>("robot_description_file");
  Place where = Place::of_parameter("robot_description");
  if (!options.description.empty() && !file.empty()) {
    return err(Problem{where, "robot_description_file is set, too", "give one of them"});
  }
  if (!file.empty()) {
    where = file;
    auto read = description::read_description(file, node.get<std::vector<std::string>>("xacro_arguments"));
    if (!read) return err(read.error());
    options.description = std::move(read.value().urdf);
    if (!read.value().places.empty()) where = "what " + file + " expands to";  // `nacelle xacro` prints it
  }
  options.frame_prefix = node.get<std::string>(kFramePrefixParameter);
  for (const std::string& entry : node.get<std::vector<std::string>>("static_transforms")) {
    auto transform = read_static_transform(entry, options.frame_prefix);
    if (!transform) return err(Problem{Place::of_parameter("static_transforms"), transform.error(), ""});
    options.static_transforms.push_back(std::move(transform).value());
  }
  if (options.description.empty() && options.static_transforms.empty()) {
    return err(Problem{where, "no robot description is given",
                       "set robot_description (URDF text) or robot_description_file, or at least static_transforms"});
  }
  if (!options.description.empty()) {
    auto tree = read_urdf(options.description, where);
    if (!tree) return err(tree.error());
    options.tree = std::move(tree).value();
  }
  // The prefix is added to every link, as in robot_state_publisher, even to one that already begins with it.
  for (Joint& joint : options.tree.joints) {
    joint.parent.insert(0, options.frame_prefix);
    joint.child.insert(0, options.frame_prefix);
  }
  if (const auto checked = check_parents(options); !checked) return err(checked.error());
  options.joints = {node.get<double>("publish_frequency"), node.get<bool>("ignore_timestamp")};
  return options;
}

}  // namespace nacelle::transforms
