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

/// What a finding is about; the word in the JSON output.
enum class About : std::uint8_t {
  LaunchFile,  ///< Its syntax, its words, its names, a circle in `after:`.
  Program,     ///< A program that is to be started beside the container.
  Plugin,      ///< A class, its library, its constructor.
  Parameter,   ///< A value, a name that nobody has, a section for nobody, a file that a parameter names.
  Device,      ///< A device that two components open.
  Type,        ///< Two ends of a topic with two types.
  Qos,         ///< Two ends whose quality of service does not fit, or a `qos:` of no topic.
  Stream,      ///< A subscription that nobody feeds.
  Service,     ///< A client of a service that nobody offers.
  Remap,       ///< A rule that hits nothing.
  Frame,       ///< A frame with two parents, a tree in pieces, data in a frame that nobody broadcasts.
  Budget,      ///< A limit that the wiring cannot keep.
  Export,      ///< A line of `export:` that shows nothing.
  Order        ///< A condition of `after:` that nobody can meet.
};
[[nodiscard]] const char* to_text(About about);

/// One thing that is wrong with a plan: `problem` says where (file:line), what (naming both ends) and the change that mends it.
struct Finding {
  Severity severity = Severity::Error;
  About about = About::LaunchFile;
  Problem problem;
  /// "error: robot.yaml:12: /lidar has no parameter 'prt'; did you mean 'port_name'?"
  [[nodiscard]] std::string text() const { return std::string{to_text(severity)} + ": " + problem.text(); }
};

[[nodiscard]] bool has_errors(const std::vector<Finding>& findings);
/// "2 errors, 1 warning"; "sound" for none.
[[nodiscard]] std::string summary(const std::vector<Finding>& findings);
/// The problems of a launch file that cannot be read, as findings.
[[nodiscard]] std::vector<Finding> findings_of(const std::vector<Problem>& launch_file);

}  // namespace nacelle::proof
