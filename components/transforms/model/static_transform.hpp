// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/base/result.hpp"
#include "nacelle/spatial/rigid_transform.hpp"

namespace nacelle::transforms {

struct StaticTransform {
  std::string parent, child;
  spatial::RigidTransform X_PC;
  friend bool operator==(const StaticTransform& a, const StaticTransform& b) {
    return a.parent == b.parent && a.child == b.child && a.X_PC.translation_m == b.X_PC.translation_m &&
           a.X_PC.rotation.coeffs() == b.X_PC.rotation.coeffs();
  }
};

/// Reads "x y z yaw pitch roll parent child" or "x y z qx qy qz qw parent child": the arguments of static_transform_publisher.
/// Frames get the prefix, unless they have it; those that begin with '/' lose the slash instead.
/// Units:  m, rad.
/// Errors: a sentence that names the wrong word.
[[nodiscard]] Result<StaticTransform, std::string> read_static_transform(const std::string& text,
                                                                         const std::string& frame_prefix = {});

}  // namespace nacelle::transforms
