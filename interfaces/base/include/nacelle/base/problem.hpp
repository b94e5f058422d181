// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace nacelle {

/// What is told to a person when something outside the program is wrong: files, parameters, names, devices.
///
/// Each part is a sentence fragment without a full stop; empty parts are left out of the text.
struct Problem {
  std::string where;    ///< "robot.launch.yaml:12" or "node /lidar, parameter port_name"
  std::string what;     ///< "no such device: /dev/ttyUSB7"; names the value
  std::string way_out;  ///< "see `ls /dev/serial/by-id`, or start with sim:=true"

  /// "where: what; way_out"
  [[nodiscard]] std::string text() const;
  friend bool operator==(const Problem&, const Problem&) = default;
};

/// The candidate that a person most likely meant, or an empty text if none is near.
/// Source: Damerau-Levenshtein distance (optimal string alignment), at most a third of the longer text.
[[nodiscard]] std::string nearest_name(std::string_view wrong, const std::vector<std::string>& candidates);

/// "did you mean 'x'?", also where only the first word of 'x' is written, or "one of a, b, c"; empty without candidates.
[[nodiscard]] std::string suggestion(std::string_view wrong, const std::vector<std::string>& candidates);

/// "a, b and c"; empty for none.
[[nodiscard]] std::string join(const std::vector<std::string>& parts, std::string_view separator = ", ");

}  // namespace nacelle
