// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/spatial/rigid_transform.hpp"

namespace nacelle::transforms {

using spatial::RigidTransform;

enum class JointKind : std::uint8_t { Fixed, Turning, Sliding };

/// A joint that follows another one: position = multiplier * other + offset.
struct Mimic {
  std::string joint;
  double multiplier{1.0};
  double offset{0.0};
};

/// One joint of the description: the frame of its child link in that of its parent link.
struct Joint {
  std::string name, parent, child;
  JointKind kind{JointKind::Fixed};
  RigidTransform origin;  ///< X_parent_child at position 0.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  std::optional<Mimic> mimic;

  /// X_parent_child at a position: rad for turning joints, m for sliding ones.
  [[nodiscard]] RigidTransform at(double position) const;
};

struct RobotTree {
  std::string name;
  std::string root;  ///< The link without a parent.
  std::vector<Joint>
      joints;  ///< In the order of their names. Floating and planar ones are left out, as their pose is no number.
  std::vector<std::string> left_out;
};

/// Reads a URDF with urdfdom.
///
/// Errors: a Problem with `where` as given and urdfdom's own words; also for a mimic chain that never ends or names no joint,
///         an axis of length zero, and a number that is not finite.
/// Threads: any, one after another (urdfdom reports its errors through one process-wide channel).
[[nodiscard]] Result<RobotTree, Problem> read_urdf(const std::string& text, const Place& where);

}  // namespace nacelle::transforms
