// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nacelle::cli {

struct BagCopyWish {
  std::string path, output;
  std::string compression = "none";
  std::vector<std::string> topics;  ///< Empty: all.
  std::string regex, exclude_regex;
  double start_offset_s = 0.0, duration_s = 0.0;  ///< From the first message; a duration of 0 has no end.
  bool despite_problems = false;                  ///< Copies what can be read, and is content with it.
};

/// Returns the error of a regular expression, or an empty text; for Option::checked().
[[nodiscard]] std::string wrong_regex(const std::string& text);

/// Copies what is wanted of a recording into a new file. Returns the exit code: kFailed if something cannot be read or written.
int copy_bag(const BagCopyWish& wish);

}  // namespace nacelle::cli
