// SPDX-License-Identifier: Apache-2.0
#include "proof/finding.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nacelle::proof {

const char* to_text(Severity severity) { return severity == Severity::Error ? "error" : "warning"; }

const char* code_text(Rule rule) {
  switch (rule) {
    case Rule::NothingToStart: return "launch_file.nothing_to_start";
    case Rule::NoProgram: return "program.not_found";
    case Rule::WrongPackage: return "plugin.wrong_package";
    case Rule::NotMade: return "plugin.not_made";
    case Rule::NotIsolated: return "plugin.not_isolated";
    case Rule::RefusedParameter: return "parameter.refused";
    case Rule::UnknownParameter: return "parameter.unknown";
    case Rule::UnusedSection: return "parameter.unused_section";
    case Rule::WheelsDiffer: return "parameter.wheels_differ";
    case Rule::NoHeading: return "stream.no_heading";
    case Rule::DeviceTwice: return "device.opened_twice";
    case Rule::TopicTypes: return "type.of_topic";
    case Rule::ServiceTypes: return "type.of_service";
    case Rule::QosMismatch: return "qos.mismatch";
    case Rule::UnusedQos: return "qos.unused";
    case Rule::NotPublished: return "stream.not_published";
    case Rule::NotOffered: return "service.not_offered";
    case Rule::UnusedRemap: return "remap.unused";
    case Rule::FrameOwners: return "frame.two_owners";
    case Rule::FrameCircle: return "frame.circle";
    case Rule::FrameTrees: return "frame.no_one_tree";
    case Rule::NoFrame: return "frame.not_broadcast";
    case Rule::UnusedBudget: return "budget.unused";
    case Rule::Budget: return "budget.exceeded";
    case Rule::UnusedExport: return "export.unused";
    case Rule::NeverMet: return "order.never_met";
    case Rule::OrderCircle: return "order.circle";
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
  for (const Problem& problem : launch_file) findings.push_back({Severity::Error, problem});
  return findings;
}

}  // namespace nacelle::proof
