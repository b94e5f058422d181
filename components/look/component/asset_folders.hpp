// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::look {

/// The files that a robot's description names: "package://my_robot/meshes/base.stl". Threads: constant; reading blocks.
class AssetFolders {
 public:
  /// Folders in which a package has a folder: /opt/robot/share for /opt/robot/share/my_robot/meshes/base.stl.
  explicit AssetFolders(std::vector<std::string> folders) : folders_(std::move(folders)) {}
  /// Errors: LookFault::NoSuchFile, also for a file outside the folder of its package.
  [[nodiscard]] Result<std::string, Problem> read(const std::string& uri) const;

 private:
  std::vector<std::string> folders_;
};

}  // namespace nacelle::look
