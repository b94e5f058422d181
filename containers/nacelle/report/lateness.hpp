// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace nacelle::report {

/// Two answers of ask::statistics() with what is looked up in them. Refers to them.
struct Interval {
  const nlohmann::json& before;
  const nlohmann::json& after;
  double seconds = 0;

  Interval(const nlohmann::json& first, const nlohmann::json& second);
  /// The row of the first answer that is `row` of the second in these keys, or null.
  [[nodiscard]] const nlohmann::json* earlier(const char* list, const nlohmann::json& row,
                                              std::initializer_list<const char*> keys) const;
  /// How much a number of `row` has grown; a row that is new began at zero, one that began anew too.
  [[nodiscard]] double growth(const nlohmann::json& row, const nlohmann::json* before_row, const char* key) const;
};

/// Why a reader is late, as a sentence; empty if it is not. `hz`: of its stream, in the interval.
[[nodiscard]] std::string why_late(const Interval& interval, const nlohmann::json& reader, double hz);

/// "12 us", "3.4 ms", "1.2 s"
[[nodiscard]] std::string time_text(double us);

}  // namespace nacelle::report
