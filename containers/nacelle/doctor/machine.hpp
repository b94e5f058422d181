// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/io/device_access.hpp"

namespace nacelle::doctor {

using io::names_of;
using io::Process;

/// Owner, group and mode of a file.
struct Access {
  uid_t owner = 0;
  gid_t group = 0;
  mode_t mode = 0;
};

/// Facts that no file of the machine contains. real_facts() asks the kernel.
struct Facts {
  WallTime now;
  /// Whether the kernel regards its wall clock as synchronised; nothing if the query fails.
  std::optional<bool> clock_is_synchronised;
  std::string version;                  ///< Of the program.
  WallTime built;                       ///< When the program's file was written; 0: unknown.
  int domain = 0;                       ///< ROS_DOMAIN_ID
  std::optional<Problem> wrong_domain;  ///< Set if ROS_DOMAIN_ID is invalid; a robot then stays off the network.
};
[[nodiscard]] Facts real_facts(std::string version);

/// The machine as the checks see it: files below a root folder, which tests can replace, and Facts.
///
/// Paths are those of the machine: "/proc/meminfo". An unreadable file counts as absent and is never an error.
/// Threads: one; it only reads.
class Machine {
 public:
  explicit Machine(Facts facts, std::filesystem::path root = "/") : facts_(std::move(facts)), root_(std::move(root)) {}

  [[nodiscard]] const Facts& facts() const { return facts_; }
  [[nodiscard]] bool exists(const std::string& path) const;
  /// Returns the first MiB of a file, without white space at the end.
  [[nodiscard]] std::optional<std::string> text(const std::string& path) const;
  [[nodiscard]] std::optional<std::int64_t> number(const std::string& path) const;
  /// Returns the value of "Key:   value" in a file of such lines. `key` has no colon.
  [[nodiscard]] std::optional<std::string> field(const std::string& path, std::string_view key) const;
  /// Returns the names in a folder, sorted.
  [[nodiscard]] std::vector<std::string> names_in(const std::string& folder) const;
  [[nodiscard]] std::optional<std::string> link(const std::string& path) const;
  /// Follows symbolic links within the root and returns the path at their end. Returns a path that is not a link
  /// unchanged.
  [[nodiscard]] std::string resolved(std::string path) const;
  [[nodiscard]] std::optional<Access> access(const std::string& path) const;

  /// Returns whether this process's user and groups (/proc/self/status) may read and write the file.
  [[nodiscard]] bool may_use(const Access& access) const;
  /// Returns a group's name, such as "dialout", or its number if /etc/group has no name for it.
  [[nodiscard]] std::string group_name(gid_t group) const;
  [[nodiscard]] bool is_root() const;
  /// As io::holders_of().
  [[nodiscard]] std::vector<Process> holders(const std::string& target) const;

 private:
  [[nodiscard]] std::filesystem::path real(const std::string& path) const;

  Facts facts_;
  std::filesystem::path root_;
};

/// Returns the number at the start of a text, after white space.
[[nodiscard]] std::optional<std::int64_t> leading_number(std::string_view text);
/// Splits a text at white space.
[[nodiscard]] std::vector<std::string> words_of(const std::string& text);

}  // namespace nacelle::doctor
