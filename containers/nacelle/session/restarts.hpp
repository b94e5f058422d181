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

/// Decides when a faulted component is reloaded: restart counts, back-off, limits. Knows components by name only. Pure.
class Restarts {
 public:
  /// A fault later than this after the last restart starts the component's count again.
  static constexpr Duration kWell = 60s;

  /// Records a fault or a failed restart. Returns when the next restart is due, or nothing if the limit is reached.
  std::optional<MonotonicTime> on_fault(const std::string& node, const FaultHandling& handling, MonotonicTime now);
  /// Returns each component whose restart is due, once.
  [[nodiscard]] std::vector<std::string> take_due(MonotonicTime now);
  /// Returns when take_due() has a result; nothing: not before the next fault.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const;
  [[nodiscard]] std::optional<MonotonicTime> due_of(const std::string& node) const;
  /// Returns the number of restarts that count. It is not reset before the next fault.
  [[nodiscard]] std::uint32_t count_of(const std::string& node) const;
  /// Cancels the component's restart and resets its count. Call it when a user handles the component.
  void forget(const std::string& node) { of_.erase(node); }

 private:
  struct Entry {
    std::uint32_t count = 0;
    std::optional<MonotonicTime> due, last;
  };
  std::map<std::string, Entry> of_;
};

}  // namespace nacelle::session
