// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace nacelle::test {

/// Runs a part of a test in a process of its own, which dies with this one: iceoryx can be started once in a process only.
/// Expectations that fail there are printed there. Returns its exit code, 0 when all held; -signal when it died of one.
[[nodiscard]] int run_in_child(const std::function<void()>& part);

}  // namespace nacelle::test
