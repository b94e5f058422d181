// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::new_package {

/// A file of a package; the path is relative to the package's folder.
struct File {
  std::string path, text;
};

/// Returns the name of the class in a package: "WheelCounter" for "wheel_counter".
[[nodiscard]] std::string class_name(const std::string& package);

/// Checks the name of a new package, which also becomes a C++ namespace, a library and a node.
/// Errors: with a name to use instead, where one is near.
[[nodiscard]] Result<void, Problem> check_name(const std::string& package);

/// Returns the files of an example package, sorted by path. Errors: the folder or a file cannot be read.
[[nodiscard]] Result<std::vector<File>, Problem> read_template(const std::string& folder);

/// Returns the files of the example package `example` (talker) under the name of a new package: its files, namespace, class,
/// library and node are renamed.
/// Errors: the new class would have the name of a type that the example uses.
[[nodiscard]] Result<std::vector<File>, Problem> rename(std::vector<File> files, const std::string& example,
                                                        const std::string& package);

/// Writes the files into a new folder. Errors: the folder exists, or cannot be written; in both cases nothing is left behind.
[[nodiscard]] Result<void, Problem> write(const std::string& folder, const std::vector<File>& files);

}  // namespace nacelle::new_package
