// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::description {

/// Access of a xacro file to other files, packages and arguments. Each member may be empty: then nothing is found.
struct XacroEnvironment {
  /// The text of a file. Errors: why it cannot be read.
  std::function<Result<std::string, Problem>(const std::string& path)> read_file;
  /// $(find package): the folder of its shared files; empty: there is no such package.
  std::function<std::string(const std::string& package)> find_package;
  /// $(env NAME), $(optenv NAME default).
  std::function<std::optional<std::string>(const std::string& name)> variable;
};

/// Files of this machine (at most 16 MiB each), its environment variables; a package is <prefix>/share/<package>, also
/// below the folders of NACELLE_PREFIX_PATH and AMENT_PREFIX_PATH.
[[nodiscard]] XacroEnvironment machine(std::vector<std::string> prefixes = {"/usr", "/usr/local"});

/// What came out of a xacro file.
struct XacroResult {
  std::string urdf;
  std::vector<std::string> warnings;  ///< "robot.xacro:12: ..."
  std::vector<Place> places;          ///< Where each element stands that became one of the URDF's; in its order.
};

/// Turns a xacro file into the XML that it describes, without its comments.
///
/// Known: property (value, default, block, scope), arg, macro with parameters and defaults (also ^, *block, **blocks), call by name,
/// insert_block, include (also optional), if, unless, element, attribute; ${} with Python's arithmetic, comparisons, strings, conditional
/// expressions and the functions of its math module; $(arg) $(find) $(env) $(optenv) $(dirname) $(cwd); $${ and $$( for the
/// characters themselves. Dictionaries, lists, load_yaml and namespaces of includes are refused by name.
/// Source of the meaning: the xacro package's documentation, https://wiki.ros.org/xacro (ROS 2: github.com/ros/xacro).
///
/// `arguments`: values for <xacro:arg>; one that the file does not declare is an error.
/// Errors: a Problem with file:line and, below it, the macros and includes on the way there. Terminates for any input: depth, number of
/// elements and size of the result are bounded. Pure but for `environment`. Threads: any.
[[nodiscard]] Result<XacroResult, Problem> expand_xacro(const std::string& path,
                                                        const std::map<std::string, std::string>& arguments,
                                                        const XacroEnvironment& environment);

}  // namespace nacelle::description
