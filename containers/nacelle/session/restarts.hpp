// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::session {

/// When which faulted component is to be loaded anew: counts, pauses, bounds. Knows nothing of components but their names. Pure.
class Restarts {
 public:
  /// A component that was well for this long begins to count anew.
  static constexpr Duration kWell = 60s;

  /// A fault, or a restart that failed. Returns when the next restart is due, or nothing when there were enough.
  std::optional<MonotonicTime> on_fault(const std::string& node, const FaultHandling& handling, MonotonicTime now);
  /// The components whose time has come; each once.
  [[nodiscard]] std::vector<std::string> take_due(MonotonicTime now);
  /// When take_due() has something to give; nothing: not before the next fault.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const;
  [[nodiscard]] std::optional<MonotonicTime> due_of(const std::string& node) const;
  /// Restarts so far, of those in a row that count.
  [[nodiscard]] std::uint32_t count_of(const std::string& node) const;
  /// A person took it in hand: nothing is due any more, and the count begins anew.
  void forget(const std::string& node) { of_.erase(node); }

 private:
  struct Entry {
    std::uint32_t count = 0;
    std::optional<MonotonicTime> due, last;
  };
  std::map<std::string, Entry> of_;
};

}  // namespace nacelle::session
