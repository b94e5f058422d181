// SPDX-License-Identifier: Apache-2.0
#include "doctor/finding.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nacelle::doctor {

const char* to_text(Severity severity) {
  switch (severity) {
    case Severity::Fine: return "fine";
    case Severity::Advice: return "advice";
    case Severity::Wrong: return "wrong";
  }
  return "?";
}

std::string Finding::text() const {
  std::string text = problem.where.text();
  if (!value.empty()) text += (text.empty() ? "" : ": ") + value;
  if (!problem.what.empty()) text += (value.empty() ? ": " : ", ") + problem.what;
  if (!problem.way_out.empty()) text += "; " + problem.way_out;
  return text;
}

bool is_something_wrong(const Findings& findings) {
  return std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.severity == Severity::Wrong; });
}

std::string summary(const Findings& findings) {
  const auto count = [&](Severity severity) {
    return std::count_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.severity == severity; });
  };
  return fmt::format("{} wrong, {} advice, {} fine", count(Severity::Wrong), count(Severity::Advice),
                     count(Severity::Fine));
}

}  // namespace nacelle::doctor
