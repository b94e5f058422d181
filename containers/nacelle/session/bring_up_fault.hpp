// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::session {

/// Why a session's bring-up fails. A failed transition, a cycle and an interruption are LifecycleFaults.
enum class BringUpFault : std::uint8_t {
  UnsoundPlan,  ///< The checks of the plan found errors, which were printed. Value: the number of errors and warnings.
  NotLoaded,    ///< A required component could not be loaded. Value: its node.
  OutOfResources,  ///< The process has no memory, threads or descriptors left; the text has the exception's words.
};
[[nodiscard]] constexpr const char* code_text(BringUpFault fault) {
  switch (fault) {
    case BringUpFault::UnsoundPlan: return "bring_up.unsound_plan";
    case BringUpFault::NotLoaded: return "bring_up.not_loaded";
    case BringUpFault::OutOfResources: return "bring_up.out_of_resources";
  }
  return "";
}

}  // namespace nacelle::session
