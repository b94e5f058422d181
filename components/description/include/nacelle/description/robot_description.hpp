// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::description {

/// A robot's URDF, and where each of its elements was written.
struct RobotDescription {
  std::string urdf;
  std::string file;           ///< That it came from; empty for a text.
  std::vector<Place> places;  ///< As in XacroResult; empty where the file is the URDF itself.

  /// "robot.xacro:30" of the element that is the `number`th in the URDF, and stands in its line `line`.
  [[nodiscard]] Place place(std::size_t number, int line) const;
};

/// Reads a URDF, or expands a xacro file (*.xacro); `xacro_arguments` are "name:=value" each.
/// Errors: a file that cannot be read or is larger than 16 MiB; those of expand_xacro(). Threads: any.
[[nodiscard]] Result<RobotDescription, Problem> read_description(const std::string& path,
                                                                 const std::vector<std::string>& xacro_arguments);

}  // namespace nacelle::description
