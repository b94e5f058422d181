// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::look {

/// 32 hexadecimal digits of the system's random generator. Errors: it has none.
[[nodiscard]] Result<std::string, Problem> random_token();

/// The file in which the owner of the robot's process finds the links with their tokens, as long as this object lives. Parameters and logs
/// are for everybody on the network, and do not have them.
class LinkFile {
 public:
  /// Returns where it is for this node: in the folder that systemd gives a service, in the user's own under /run, or in
  /// /tmp/nacelle-USER.
  [[nodiscard]] static std::string path_for(const std::string& node);
  /// Writes it for the owner alone, in a folder of a service for its group as well. Errors: the folder belongs to another user, others may
  /// write to it, or it cannot be written to.
  [[nodiscard]] static Result<LinkFile, Problem> write(const std::string& path, const std::string& text);
  LinkFile(LinkFile&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  LinkFile& operator=(LinkFile&&) = delete;
  ~LinkFile();

 private:
  explicit LinkFile(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

}  // namespace nacelle::look
