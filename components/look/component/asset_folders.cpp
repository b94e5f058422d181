// SPDX-License-Identifier: Apache-2.0
#include "look/component/asset_folders.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "look/protocol/look_fault.hpp"
#include "nacelle/base/files.hpp"

namespace nacelle::look {

Result<std::string, Problem> AssetFolders::read(const std::string& uri) const {
  namespace fs = std::filesystem;
  constexpr std::string_view kScheme = "package://";
  const auto refuse = [&](std::string what) {
    return err(Problem{uri.substr(0, 200), std::move(what),
                       "asset_folders names the folders in which packages are looked for", LookFault::NoSuchFile});
  };
  if (!uri.starts_with(kScheme)) return refuse("begins not with package://");
  const std::string path = uri.substr(kScheme.size());
  const auto slash = path.find('/');
  if (slash == std::string::npos || slash == 0) return refuse("names no file of a package");
  for (const std::string& folder : folders_) {
    std::error_code error;
    const fs::path package = fs::canonical(fs::path{folder} / path.substr(0, slash), error);
    if (error) continue;
    const fs::path file = fs::canonical(package / path.substr(slash + 1), error);
    if (error) continue;
    // Neither ".." nor a link leads out of it.
    const auto [end, rest] = std::mismatch(package.begin(), package.end(), file.begin(), file.end());
    if (end != package.end()) return refuse("is not in the folder of its package");
    auto read = read_regular_file(file.string());
    if (!read) return refuse(read.error().text());
    return std::move(*read);
  }
  return refuse("is in none of the folders");
}

}  // namespace nacelle::look
