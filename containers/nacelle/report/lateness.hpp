// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace nacelle::report {

/// Two answers of ask::statistics(), which must outlive it, with look-ups in them.
struct Interval {
  const nlohmann::json& before;
  const nlohmann::json& after;
  double seconds = 0;

  Interval(const nlohmann::json& first, const nlohmann::json& second);
  /// Returns the row of the first answer that equals `row` of the second one in these keys, or null.
  [[nodiscard]] const nlohmann::json* earlier(const char* list, const nlohmann::json& row,
                                              std::initializer_list<const char*> keys) const;
  /// Returns the growth of a number of `row`. A row that is new, or whose counter was reset, counts from zero.
  [[nodiscard]] double growth(const nlohmann::json& row, const nlohmann::json* before_row, const char* key) const;
};

/// Returns why a reader is late; empty if it is not. `hz`: the rate of its stream in the interval.
[[nodiscard]] std::string why_late(const Interval& interval, const nlohmann::json& reader, double hz);

/// Returns "12 us", "3.4 ms" or "1.2 s".
[[nodiscard]] std::string time_text(double us);

}  // namespace nacelle::report
