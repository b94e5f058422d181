// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/time.hpp"

namespace nacelle::session {

/// The facts of a crash record. It names one component, or all components of the library that crashed.
struct CrashFacts {
  std::string id;  ///< Time and process; differs for every crash.
  std::vector<std::string> nodes;
  bool early = false;  ///< Within EarlyCrashes::kEarly of the component's activation, or before it.
  std::string text;    ///< "SIGSEGV at address 0x0 in /lidar, subscription /cmd, at lidar::Driver::read()".
};
/// Parses a crash record. Returns nothing for any other text. Pure.
[[nodiscard]] std::optional<CrashFacts> crash_facts(const std::string& record);

/// Counts the crashes of each component that came soon after its activation, across the runs of a container that is
/// resumed. The counts are kept in a file beside the state file. A component that reaches kMost is left out, so that it
/// cannot end the robot repeatedly. A later crash resets the count.
/// Threads: one.
class EarlyCrashes {
 public:
  static constexpr Duration kEarly = std::chrono::seconds{30};
  static constexpr std::uint32_t kMost = 2;

  explicit EarlyCrashes(std::string path) : path_(std::move(path)) {}

  /// Counts the crash that ended the last run. Without `resume`, resets all counts. `last`: the present crash record,
  /// which may belong to an earlier run.
  void begin(bool resume, const std::optional<CrashFacts>& last);
  /// Returns whether `last` of begin() belongs to the last run.
  [[nodiscard]] bool last_run_crashed() const { return last_run_crashed_; }
  [[nodiscard]] bool is_left_out(const std::string& node) const;
  /// Returns "2 crashes within 30 s of its activation, the last: SIGSEGV ..."; empty if there was none.
  [[nodiscard]] std::string reason(const std::string& node) const;
  [[nodiscard]] std::vector<std::string> nodes() const;
  /// Resets the count of a component that has run for kEarly.
  void forget(const std::string& node);
  /// Removes the file. Call it at an orderly end.
  void remove();

 private:
  struct Entry {
    std::uint32_t count = 0;
    std::string text;
  };
  void read();
  void write() const;

  const std::string path_;
  std::string counted_;  // the id of the last record that was counted
  bool last_run_crashed_ = false;
  std::map<std::string, Entry> of_;
};

}  // namespace nacelle::session
