// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::runtime {

/// True on an executor's threads: nothing may wait there for what another callback does.
inline thread_local bool this_thread_runs_callbacks = false;

/// Tells threads apart at the price of an address.
inline std::uintptr_t this_thread_mark() { return reinterpret_cast<std::uintptr_t>(&this_thread_runs_callbacks); }

}  // namespace nacelle::runtime
