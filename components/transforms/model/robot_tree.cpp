// SPDX-License-Identifier: Apache-2.0
#include "transforms/model/robot_tree.hpp"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <tinyxml2.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>

#include "nacelle/base/mutex.hpp"
#include "nacelle/base/xml.hpp"

namespace nacelle::transforms {
namespace {

// Collects what urdfdom says while it parses; it knows no other way to report.
class Listener final : public console_bridge::OutputHandler {
 public:
  Listener() : before_(console_bridge::getOutputHandler()) { console_bridge::useOutputHandler(this); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() override { console_bridge::useOutputHandler(before_); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR || text_.size() > 500) return;
    text_ += (text_.empty() ? "" : "; ") + text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  console_bridge::OutputHandler* before_;
  std::string text_;
};

Mutex& parser_lock() {
  static Mutex lock;
  return lock;
}

RigidTransform transform_of(const urdf::Pose& pose) {
  RigidTransform X;
  X.rotation = Eigen::Quaterniond{pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z};
  X.translation_m = {pose.position.x, pose.position.y, pose.position.z};
  return X;
}

std::optional<JointKind> kind_of(int type) {
  switch (type) {
    case urdf::Joint::FIXED: return JointKind::Fixed;
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS: return JointKind::Turning;
    case urdf::Joint::PRISMATIC: return JointKind::Sliding;
    default: return std::nullopt;
  }
}

// The chain of mimic joints must end at a joint that is none.
std::optional<std::string> mimic_trouble(const RobotTree& tree) {
  std::map<std::string, const Joint*> by_name;
  for (const Joint& joint : tree.joints) by_name[joint.name] = &joint;
  for (const Joint& joint : tree.joints) {
    const Joint* at = &joint;
    for (std::size_t hops = 0; at->mimic; ++hops) {
      const auto next = by_name.find(at->mimic->joint);
      if (next == by_name.end())
        return fmt::format("joint '{}' mimics '{}', which is not a movable joint", at->name, at->mimic->joint);
      if (hops > tree.joints.size()) return fmt::format("joint '{}' mimics itself in the end", joint.name);
      at = next->second;
    }
  }
  return std::nullopt;
}

Result<Joint, std::string> joint_of(const urdf::Joint& from, JointKind kind) {
  Joint joint{from.name,
              from.parent_link_name,
              from.child_link_name,
              kind,
              transform_of(from.parent_to_joint_origin_transform),
              {},
              {}};
  if (!joint.origin.rotation.coeffs().allFinite() || !joint.origin.translation_m.allFinite()) {
    return err(fmt::format("the origin of joint '{}' is not finite", from.name));
  }
  joint.origin.rotation.normalize();
  if (kind != JointKind::Fixed) {
    joint.axis = {from.axis.x, from.axis.y, from.axis.z};
    const double length = joint.axis.norm();
    if (!std::isfinite(length) || length < 1e-9)
      return err(fmt::format("the axis of joint '{}' has no direction", from.name));
    joint.axis /= length;
    if (from.mimic) joint.mimic = Mimic{from.mimic->joint_name, from.mimic->multiplier, from.mimic->offset};
  }
  return joint;
}

}  // namespace

RigidTransform Joint::at(double position) const {
  switch (kind) {
    case JointKind::Turning: {
      const double half = 0.5 * position;
      const double s = std::sin(half);
      return {origin.rotation * Eigen::Quaterniond{std::cos(half), s * axis.x(), s * axis.y(), s * axis.z()},
              origin.translation_m};
    }
    case JointKind::Sliding: return {origin.rotation, origin.translation_m + origin.rotation * (position * axis)};
    case JointKind::Fixed: break;
  }
  return origin;
}

Result<RobotTree, Problem> read_urdf(const std::string& text, const Place& where) {
  const LockGuard lock{parser_lock()};
  const char* const way_out = "check it with `check_urdf` (package liburdfdom-tools)";
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
    return err(Problem{where, "the robot description is empty",
                       "set robot_description to a URDF text, or robot_description_file to a file"});
  }
  // urdfdom's own words differ between its releases, and the older one's recursion has no bound.
  {
    tinyxml2::XMLDocument document;
    if (auto parsed = parse_xml(document, text, where.text()); !parsed) {
      Problem problem = parsed.error();
      if (problem.way_out.empty()) problem.way_out = way_out;
      return err(std::move(problem));
    }
  }
  urdf::ModelInterfaceSharedPtr model;
  std::string said;
  {
    Listener listener;
    try {
      model = urdf::parseURDF(text);
    } catch (const std::exception& e) {
      return err(Problem{where, fmt::format("no robot description: {}", e.what()), way_out});
    }
    said = listener.text();
  }
  if (!model)
    return err(Problem{where, fmt::format("no robot description: {}", said.empty() ? "not a URDF" : said), way_out});
  if (!model->getRoot()) return err(Problem{where, "the robot description has no root link", way_out});

  RobotTree tree;
  tree.name = model->getName();
  tree.root = model->getRoot()->name;
  for (const auto& [name, joint] : model->joints_) {
    const auto kind = kind_of(joint->type);
    if (!kind) {
      tree.left_out.push_back(name);
      continue;
    }
    auto read = joint_of(*joint, *kind);
    if (!read) return err(Problem{where, read.error(), way_out});
    tree.joints.push_back(std::move(read).value());
  }
  if (const auto trouble = mimic_trouble(tree))
    return err(Problem{where, *trouble, "let it name a joint that moves by itself"});
  return tree;
}

}  // namespace nacelle::transforms
