// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::proof {

enum class Severity : std::uint8_t {
  Warning,  ///< Worth a look; the robot runs as the plan says.
  Error     ///< The plan does not say what it means, or cannot be kept: nothing is activated.
};
[[nodiscard]] const char* to_text(Severity severity);

/// The rules of a check, and the codes of what they find. The word before the dot says what the finding is about.
enum class Rule : std::uint8_t {
  NothingToStart,    ///< The plan has no component and no program.
  NoProgram,         ///< A program that is to be started beside the container is not there.
  WrongPackage,      ///< The class is not of the package that `pkg:` names.
  NotMade,           ///< No such class or library, or its constructor failed.
  NotIsolated,       ///< `isolate: process` of a component with ties to its process.
  RefusedParameter,  ///< A value that the parameter cannot have, or a file that it names.
  UnknownParameter,  ///< A name that the node does not declare.
  UnusedSection,     ///< A parameter file's section for a node that is not there.
  WheelsDiffer,      ///< The base and the odometry measure the same wheels, and have different values or joints.
  DeviceTwice,       ///< Two components open one device.
  TopicTypes,        ///< Two ends of a topic have two types.
  ServiceTypes,      ///< A client and a server of a service have two types.
  QosMismatch,       ///< A subscription gets nothing from a publisher, since their quality of service does not fit.
  UnusedQos,         ///< A `qos:` of no topic, or of the wrong side.
  NotPublished,      ///< A subscription of a topic that no node publishes.
  NotOffered,        ///< A client of a service that no node offers.
  UnusedRemap,       ///< A rule that hits nothing.
  FrameOwners,       ///< A frame with two parents, or broadcast twice.
  FrameCircle,       ///< Frames that are below each other.
  FrameTrees,        ///< Transforms that do not meet.
  NoFrame,           ///< A parameter names a frame that no node broadcasts.
  UnusedBudget,      ///< A budget of no topic.
  Budget,            ///< A limit that the wiring cannot keep.
  UnusedExport,      ///< A line of `export:` that shows nothing.
  NeverMet,          ///< A condition of `after:` that cannot be met.
  OrderCircle        ///< Components that wait for each other.
};
[[nodiscard]] const char* code_text(Rule rule);

/// One thing that is wrong with a plan: `problem` says where (file:line), what (naming both ends) and the change that mends it.
struct Finding {
  Severity severity = Severity::Error;
  Problem problem;
  /// "qos": the first word of the code; also in the JSON output.
  [[nodiscard]] std::string about() const { return problem.code.text().substr(0, problem.code.text().find('.')); }
  /// "error: robot.yaml:12: /lidar has no parameter 'prt'; did you mean 'port_name'?"
  [[nodiscard]] std::string text() const { return std::string{to_text(severity)} + ": " + problem.text(); }
};

[[nodiscard]] bool has_errors(const std::vector<Finding>& findings);
/// "2 errors, 1 warning"; "sound" for none.
[[nodiscard]] std::string summary(const std::vector<Finding>& findings);
/// The problems of a launch file that cannot be read, as findings.
[[nodiscard]] std::vector<Finding> findings_of(const std::vector<Problem>& launch_file);

}  // namespace nacelle::proof
