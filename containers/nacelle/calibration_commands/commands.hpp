// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/command.hpp"

namespace nacelle::cli {

void add_imu_commands(Command& root);
void add_base_commands(Command& root);

}  // namespace nacelle::cli
