// SPDX-License-Identifier: Apache-2.0
#include "drive/run_folder.hpp"

#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace nacelle::drive {

RunFolder::RunFolder() {
  const char* const base = std::getenv("XDG_RUNTIME_DIR");
  for (const std::string& where : {std::string{base != nullptr ? base : ""}, std::string{"/dev/shm"}}) {
    std::string name = where + "/nacelle-drive-XXXXXX";
    if (!where.empty() && ::mkdtemp(name.data()) != nullptr) {
      path_ = name;
      return;
    }
  }
}

RunFolder::~RunFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace nacelle::drive
