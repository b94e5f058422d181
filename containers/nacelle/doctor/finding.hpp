// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::doctor {

enum class Severity {
  Fine,    ///< Looked at, and as it should be.
  Advice,  ///< The robot works, and would work better otherwise.
  Wrong,   ///< Something will not work.
};
[[nodiscard]] const char* to_text(Severity severity);  // "fine", "advice", "wrong"

/// One thing that was looked at.
struct Finding {
  Severity severity = Severity::Fine;
  std::string about;  ///< "devices", "clock", ...
  std::string value;  ///< What was found: "12 MB", "root:dialout rw-rw----".
  Problem problem;    ///< `what` is empty where all is well.

  [[nodiscard]] std::string text() const;
};
using Findings = std::vector<Finding>;

[[nodiscard]] bool is_something_wrong(const Findings& findings);
/// "2 wrong, 1 advice, 14 fine"
[[nodiscard]] std::string summary(const Findings& findings);

}  // namespace nacelle::doctor
