// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::proof {

enum class Severity : std::uint8_t {
  Warning,  ///< May be a mistake; the robot runs as planned.
  Error     ///< The plan is contradictory or impossible; nothing is activated.
};
[[nodiscard]] const char* to_text(Severity severity);

/// The rules of a check, and the codes of their findings. The word before the dot of a code is the subject.
enum class Rule : std::uint8_t {
  NothingToStart,    ///< The plan has no component and no program.
  NoProgram,         ///< A program to start beside the container does not exist.
  WrongPackage,      ///< The class is not in the package that `pkg:` names.
  NotMade,           ///< No such class or library, or its constructor failed.
  NotIsolated,       ///< `isolate: process` for a component with ties to its process.
  RefusedParameter,  ///< The component refuses a value, or a file that it names.
  UnknownParameter,  ///< The node declares no parameter of this name.
  UnusedSection,     ///< A parameter file's section for a node that does not exist.
  WheelsDiffer,      ///< Base and odometry have different values or joints for the same wheels.
  NoHeading,         ///< A transform of GPS fixes gets no heading, and has no datum.
  DeviceTwice,       ///< Two components open the same device.
  TopicTypes,        ///< Endpoints of a topic have different types.
  ServiceTypes,      ///< Client and server of a service have different types.
  QosMismatch,       ///< A subscription's QoS is incompatible with a publisher's.
  UnusedQos,         ///< A `qos:` for a topic or a side that the component does not have.
  NotPublished,      ///< No node publishes a subscription's topic.
  NotOffered,        ///< No node offers a client's service.
  UnusedRemap,       ///< A remap rule that changes no name.
  FrameOwners,       ///< A frame has two parents, or two broadcasters.
  FrameCircle,       ///< Frames form a cycle.
  FrameTrees,        ///< The transforms form several trees.
  NoFrame,           ///< A parameter names a frame that no node broadcasts.
  UnusedBudget,      ///< A budget for a topic that its component does not have.
  Budget,            ///< The wiring exceeds a limit.
  UnusedExport,      ///< A line of `export:` that matches no topic or service.
  NeverMet,          ///< An `after:` condition that cannot hold.
  OrderCircle        ///< Components wait for each other.
};
[[nodiscard]] const char* code_text(Rule rule);

/// One problem of a plan. `problem` names the place (file:line), what is wrong (with both ends) and the change that
/// fixes it.
struct Finding {
  Severity severity = Severity::Error;
  Problem problem;
  /// Returns the subject: the first word of the code, such as "qos". It is also in the JSON output.
  [[nodiscard]] std::string about() const { return problem.code.text().substr(0, problem.code.text().find('.')); }
  /// Returns "error: robot.yaml:12: /lidar has no parameter 'prt'; did you mean 'port_name'?".
  [[nodiscard]] std::string text() const { return std::string{to_text(severity)} + ": " + problem.text(); }
};

[[nodiscard]] bool has_errors(const std::vector<Finding>& findings);
/// Returns "2 errors, 1 warning"; "sound" for none.
[[nodiscard]] std::string summary(const std::vector<Finding>& findings);
/// Returns the problems of a launch file that cannot be read, as errors.
[[nodiscard]] std::vector<Finding> findings_of(const std::vector<Problem>& launch_file);

}  // namespace nacelle::proof
