// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/guarded.hpp"

namespace nacelle {

/// The wheels of a base, as its parameters say.
struct BaseWheels {
  std::string node, name_space;  ///< Of the base: "/robot1/diff_drive", "/robot1".
  std::vector<std::string> left_joints, right_joints;
  double separation_m = 0.0, radius_m = 0.0;
  double separation_multiplier = 1.0, left_radius_multiplier = 1.0, right_radius_multiplier = 1.0;
};

/// The bases of a container, for components that need the same wheels (odometry). A base enters its own when it is made, and takes
/// them out when it goes. Threads: any.
using BaseWheelsList = Guarded<std::vector<BaseWheels>>;

/// For Node::shared_object(): the list of a container. It ties no component to its process: without a base in it there is none.
inline constexpr const char* kBaseWheelsName = "nacelle.base_wheels";
[[nodiscard]] std::shared_ptr<void> make_base_wheels();

}  // namespace nacelle
