// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <thread>

namespace nacelle::runtime {

/// The threads of executors. test/model replaces this header, and futex.hpp, with simulated ones.
using Thread = std::thread;

}  // namespace nacelle::runtime
