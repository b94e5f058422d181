// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "answers/robot.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"
#include "session/composition.hpp"
#include "session/early_crashes.hpp"

namespace nacelle::session {

class Supervision;

/// Returns the container's present composition, for a later resume. It includes the components that were left out,
/// unless a user has loaded them since.
[[nodiscard]] Composition composition_of(answers::Robot& robot, const Supervision& supervision,
                                         const std::vector<ComposedComponent>& left_out);

/// Returns the path of the crash record: the state file's with `.crash` appended.
[[nodiscard]] std::string crash_file_of(const std::string& state_file);
/// Returns the content of a crash record, or nothing if there is none.
[[nodiscard]] std::optional<CrashFacts> read_crash(const std::string& crash_file);

}  // namespace nacelle::session
