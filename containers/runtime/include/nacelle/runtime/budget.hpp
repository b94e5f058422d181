// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/runtime/reports.hpp"

namespace nacelle::runtime {

class Container;

/// Limits of a stream, from the launch file.
struct StreamBudget {
  Place where;        ///< In the launch file.
  std::string topic;  ///< Fully qualified.
  std::optional<std::uint64_t>
      max_copies;                   ///< Copies per message that publish() may make for readers that want to own it.
  std::optional<Duration> max_age;  ///< From publish() to the start of a callback.
  std::optional<double> min_hz;
};

/// A breach of a limit, or its end.
struct BudgetEvent {
  std::string topic;
  std::string limit;   ///< "min_hz 25"
  bool broken = true;  ///< False: the limit is met again.
  std::string cause;   ///< The measured value, and the cause if it is known.
  Place where;
  [[nodiscard]] std::string text() const;
};

/// Compares streams with their budgets: the wiring before anything runs, rate and age while it runs.
///
/// Threads: one. It only reads the container's counters, so it costs the streams nothing.
class BudgetWatch {
 public:
  explicit BudgetWatch(std::vector<StreamBudget> budgets) : entries_(budgets.begin(), budgets.end()) {}
  [[nodiscard]] bool empty() const { return entries_.empty(); }

  /// Checks max_copies against the declarations of publishers and subscriptions: an impossible budget fails the
  /// bring-up.
  [[nodiscard]] std::vector<Problem> check_wiring(const Container& container) const;

  /// Checks rate and age since the last call, and returns the limits whose state has changed. The first call only
  /// records the counters. Called about once a second; a rate below 2 Hz is judged over two of its periods.
  [[nodiscard]] std::vector<BudgetEvent> look(const Container& container, MonotonicTime now);

 private:
  struct Entry {
    explicit Entry(StreamBudget b) : budget(std::move(b)) {}
    StreamBudget budget;
    std::optional<MonotonicTime> rate_since, age_since;
    std::uint64_t published = 0, unpublished = 0, late = 0;
    bool slow = false, old = false;
  };
  void look_at_rate(Entry& entry, const StreamReport* stream, MonotonicTime now, std::vector<BudgetEvent>& events);
  void look_at_age(Entry& entry, const Container& container, MonotonicTime now, std::vector<BudgetEvent>& events);

  std::vector<Entry> entries_;
  std::vector<StreamReport> streams_;
};

}  // namespace nacelle::runtime
