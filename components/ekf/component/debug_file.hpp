// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::ekf {

/// A text file in memory (a tmpfs), for output that would wear out a robot's card: the last 8 to 16 MiB of what was written.
///
/// At 8 MiB the file is renamed to "<path>.1", in place of an older one, and begun again.
/// Threads: one. Allocates: when it is opened and renamed.
class DebugFile {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{8} * 1024 * 1024;

  /// Empties the file, or makes it (0600), with its folder if it is the default one.
  /// Errors: its folder is not in memory or cannot be written to.
  [[nodiscard]] static Result<DebugFile, Problem> open(std::string path, std::size_t most_bytes = kMostBytes);

  /// Where a name of `debug_out_file` is: an absolute path as it is; another one in the folder of the service ($RUNTIME_DIRECTORY), else
  /// of the user ($XDG_RUNTIME_DIR/nacelle), else /dev/shm/nacelle-<uid>. An empty name is "robot_localization_debug.<node>.txt".
  [[nodiscard]] static std::string path_for(const std::string& name, const std::string& node);

  /// Appends; false if there was no room, which ends the output.
  [[nodiscard]] bool write(std::string_view text);
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { static_cast<void>(std::fclose(file)); }
  };
  using File = std::unique_ptr<std::FILE, Close>;
  [[nodiscard]] static File create(const std::string& path);
  DebugFile(std::string path, std::size_t most_bytes, File file)
      : path_(std::move(path)), most_bytes_(most_bytes), file_(std::move(file)) {}

  std::string path_;
  std::size_t most_bytes_;
  std::size_t bytes_{0};
  File file_;
};

}  // namespace nacelle::ekf
