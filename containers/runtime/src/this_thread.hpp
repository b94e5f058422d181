// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::runtime {

/// True on an executor's threads, which must not wait for another callback.
inline thread_local bool this_thread_runs_callbacks = false;

/// Returns a number that identifies the calling thread. Costs no more than taking an address.
inline std::uintptr_t this_thread_mark() { return reinterpret_cast<std::uintptr_t>(&this_thread_runs_callbacks); }

}  // namespace nacelle::runtime
