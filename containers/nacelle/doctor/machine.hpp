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

namespace nacelle::doctor {

/// A process as /proc shows it.
struct Process {
  int pid = 0;
  std::string name;
  friend bool operator==(const Process&, const Process&) = default;
};

/// Who may open a file.
struct Access {
  uid_t owner = 0;
  gid_t group = 0;
  mode_t mode = 0;
};

/// What no file of the machine tells; real_facts() asks the kernel.
struct Facts {
  WallTime now;
  /// Whether the kernel takes its wall clock for synchronised; nothing if it cannot be asked.
  std::optional<bool> clock_is_synchronised;
  std::string version;                  ///< Of the program.
  WallTime built;                       ///< When the program's file was written; 0: unknown.
  int domain = 0;                       ///< ROS_DOMAIN_ID
  std::optional<Problem> wrong_domain;  ///< It says something else, which keeps a robot off the network.
};
[[nodiscard]] Facts real_facts(std::string version);

/// The machine as the checks see it: files below a root folder, which tests fabricate, and the facts that no file tells.
///
/// Paths are those of the machine: "/proc/meminfo". What cannot be read is absent, never an error.
/// Threads: one; it only reads.
class Machine {
 public:
  explicit Machine(Facts facts, std::filesystem::path root = "/") : facts_(std::move(facts)), root_(std::move(root)) {}

  [[nodiscard]] const Facts& facts() const { return facts_; }
  [[nodiscard]] bool exists(const std::string& path) const;
  /// At most a megabyte, without white space at the end.
  [[nodiscard]] std::optional<std::string> text(const std::string& path) const;
  [[nodiscard]] std::optional<std::int64_t> number(const std::string& path) const;
  /// The value of "Key:   value" in a file of such lines; without a colon in `key`.
  [[nodiscard]] std::optional<std::string> field(const std::string& path, std::string_view key) const;
  /// Sorted.
  [[nodiscard]] std::vector<std::string> names_in(const std::string& folder) const;
  [[nodiscard]] std::optional<std::string> link(const std::string& path) const;
  /// The path that symbolic links lead to, within the root; the path itself if it is none.
  [[nodiscard]] std::string resolved(std::string path) const;
  [[nodiscard]] std::optional<Access> access(const std::string& path) const;

  /// Whether this process's user and groups (/proc/self/status) may read and write.
  [[nodiscard]] bool may_use(const Access& access) const;
  /// "dialout", or the number where /etc/group has no name.
  [[nodiscard]] std::string group_name(gid_t group) const;
  [[nodiscard]] bool is_root() const;
  /// The processes with a descriptor whose link in /proc/PID/fd reads so: a path, or "socket:[1234]". Other users' are seen by
  /// root only.
  [[nodiscard]] std::vector<Process> holders(const std::string& target) const;

 private:
  [[nodiscard]] std::filesystem::path real(const std::string& path) const;

  Facts facts_;
  std::filesystem::path root_;
};

/// The first number of a text, behind white space.
[[nodiscard]] std::optional<std::int64_t> leading_number(std::string_view text);
/// What lies between white space.
[[nodiscard]] std::vector<std::string> words_of(const std::string& text);
/// "modem (12), cat (14)"
[[nodiscard]] std::string names_of(const std::vector<Process>& processes);

}  // namespace nacelle::doctor
