// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/session/composition.hpp"
#include "nacelle/session/early_crashes.hpp"

namespace nacelle::session {

class Session;
class Supervision;

/// What the session's container holds now, to come back to.
[[nodiscard]] Composition composition_of(Session& session, const Supervision& supervision);

/// Beside the state file.
[[nodiscard]] std::string crash_file_of(const std::string& state_file);
/// Returns what the record in a file says, or nothing if there is none.
[[nodiscard]] std::optional<CrashFacts> read_crash(const std::string& crash_file);

}  // namespace nacelle::session
