// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/problem.hpp"

namespace nacelle::launch {

/// What is wrong with a launch file or a parameter file.
enum class LaunchFault : std::uint8_t {
  Unreadable,   ///< It cannot be read, or is neither YAML nor XML.
  Form,         ///< Something has another form than is expected there: text for a map, a list for a value.
  UnknownKey,   ///< A key, an attribute or an action that is not known there.
  MissingKey,   ///< A key without which the rest means nothing.
  Refused,      ///< A word of ROS 2 that Nacelle does not do; the text says what to write instead.
  WrongValue,   ///< A key cannot have this value.
  Misplaced,    ///< It is right in another place, or without another key.
  Twice,        ///< It stands there a second time.
  UnknownName,  ///< It names an argument, a variable, a package, a container or a node that is not there.
  Circle,       ///< Conditions or files wait for each other.
  TooMuch,      ///< It is larger, longer or deeper than any robot's.
};
[[nodiscard]] constexpr const char* code_text(LaunchFault fault) {
  switch (fault) {
    case LaunchFault::Unreadable: return "launch_file.unreadable";
    case LaunchFault::Form: return "launch_file.form";
    case LaunchFault::UnknownKey: return "launch_file.unknown_key";
    case LaunchFault::MissingKey: return "launch_file.missing_key";
    case LaunchFault::Refused: return "launch_file.refused";
    case LaunchFault::WrongValue: return "launch_file.wrong_value";
    case LaunchFault::Misplaced: return "launch_file.misplaced";
    case LaunchFault::Twice: return "launch_file.twice";
    case LaunchFault::UnknownName: return "launch_file.unknown_name";
    case LaunchFault::Circle: return "launch_file.circle";
    case LaunchFault::TooMuch: return "launch_file.too_much";
  }
  return "";
}

/// The problem with this code, if it has none of its own (a library below has found it).
[[nodiscard]] inline Problem coded(Problem problem, LaunchFault fault) {
  if (problem.code.empty()) problem.code = fault;
  return problem;
}

}  // namespace nacelle::launch
