// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::drive {

/// A folder in RAM for one run's device links, truth and report; gone with the object.
class RunFolder {
 public:
  RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  ~RunFolder();

  /// Returns its path; empty if it cannot be made.
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace nacelle::drive
