// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::runtime {

/// True on an executor's threads: nothing may wait there for what another callback does.
inline thread_local bool this_thread_runs_callbacks = false;

}  // namespace nacelle::runtime
