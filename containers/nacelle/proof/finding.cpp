// SPDX-License-Identifier: Apache-2.0
#include "nacelle/proof/finding.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nacelle::proof {

const char* to_text(Severity severity) { return severity == Severity::Error ? "error" : "warning"; }

const char* to_text(About about) {
  switch (about) {
    case About::LaunchFile: return "launch_file";
    case About::Program: return "program";
    case About::Plugin: return "plugin";
    case About::Parameter: return "parameter";
    case About::Device: return "device";
    case About::Type: return "type";
    case About::Qos: return "qos";
    case About::Stream: return "stream";
    case About::Service: return "service";
    case About::Remap: return "remap";
    case About::Frame: return "frame";
    case About::Budget: return "budget";
    case About::Export: return "export";
    case About::Order: return "order";
  }
  return "";
}

bool has_errors(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings, [](const Finding& finding) { return finding.severity == Severity::Error; });
}

std::string summary(const std::vector<Finding>& findings) {
  const auto errors = std::ranges::count(findings, Severity::Error, &Finding::severity);
  const auto warnings = std::ranges::count(findings, Severity::Warning, &Finding::severity);
  std::string text;
  if (errors != 0) text = fmt::format("{} error{}", errors, errors == 1 ? "" : "s");
  if (warnings != 0)
    text += fmt::format("{}{} warning{}", text.empty() ? "" : ", ", warnings, warnings == 1 ? "" : "s");
  return text.empty() ? "sound" : text;
}

std::vector<Finding> findings_of(const std::vector<Problem>& launch_file) {
  std::vector<Finding> findings;
  for (const Problem& problem : launch_file) findings.push_back({Severity::Error, About::LaunchFile, problem});
  return findings;
}

}  // namespace nacelle::proof
