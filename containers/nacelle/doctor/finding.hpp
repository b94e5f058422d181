// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::doctor {

enum class Severity {
  Fine,    ///< Checked, and in order.
  Advice,  ///< The robot works, but could work better.
  Wrong,   ///< Something will not work.
};
[[nodiscard]] const char* to_text(Severity severity);  // "fine", "advice", "wrong"

/// The result of one check.
struct Finding {
  Severity severity = Severity::Fine;
  std::string about;  ///< "devices", "clock", ...
  std::string value;  ///< What was found: "12 MB", "rwrw-- of group dialout".
  Problem problem;    ///< `what` is empty for Severity::Fine.

  [[nodiscard]] std::string text() const;
};
using Findings = std::vector<Finding>;

[[nodiscard]] bool is_something_wrong(const Findings& findings);
/// Returns "2 wrong, 1 advice, 14 fine".
[[nodiscard]] std::string summary(const Findings& findings);

}  // namespace nacelle::doctor
