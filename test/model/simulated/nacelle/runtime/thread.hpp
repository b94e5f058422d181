// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../../../scheduler.hpp"

namespace nacelle::runtime {
using Thread = model::Thread;
}  // namespace nacelle::runtime
