// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/node.hpp"
#include "transforms/model/joint_transforms.hpp"
#include "transforms/model/static_transform.hpp"

namespace nacelle::transforms {

/// robot_state_publisher's parameters, and transforms that no description holds.
struct TransformsOptions {
  std::string description;  ///< The URDF; empty if neither parameter is given.
  RobotTree tree;
  std::vector<StaticTransform> static_transforms;  ///< Of the parameter only.
  std::string frame_prefix;
  JointTransformsOptions joints;
};

void declare_transforms_parameters(Node& node);
/// Reads the parameters and the description they name.
/// Errors: a Problem that names the parameter or file: not readable, no URDF, no transform, a frame with two parents.
[[nodiscard]] Result<TransformsOptions, Problem> read_transforms_parameters(const Node& node);

}  // namespace nacelle::transforms
