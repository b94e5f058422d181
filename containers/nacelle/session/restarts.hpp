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

/// Decides when to reload a faulted component: counts, back-off, limits. Knows only the names of components. Pure.
class Restarts {
 public:
  /// The count of a component is reset after this time without a fault.
  static constexpr Duration kWell = 60s;

  /// Records a fault, or a failed restart. Returns when the next restart is due, or nothing if the maximum is reached.
  std::optional<MonotonicTime> on_fault(const std::string& node, const FaultHandling& handling, MonotonicTime now);
  /// Returns the components whose restart is due; each once.
  [[nodiscard]] std::vector<std::string> take_due(MonotonicTime now);
  /// Returns when take_due() has a result; nothing: not before the next fault.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const;
  [[nodiscard]] std::optional<MonotonicTime> due_of(const std::string& node) const;
  /// Returns the number of restarts that count so far.
  [[nodiscard]] std::uint32_t count_of(const std::string& node) const;
  /// Call when a user handles the component: cancels its restart and resets the count.
  void forget(const std::string& node) { of_.erase(node); }

 private:
  struct Entry {
    std::uint32_t count = 0;
    std::optional<MonotonicTime> due, last;
  };
  std::map<std::string, Entry> of_;
};

}  // namespace nacelle::session
