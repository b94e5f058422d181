// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <thread>

namespace nacelle::runtime {

/// What executors run on. test/model puts simulated threads in its place, as it does with futex.hpp.
using Thread = std::thread;

}  // namespace nacelle::runtime
