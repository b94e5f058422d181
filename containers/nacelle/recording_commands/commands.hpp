// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/command.hpp"

namespace nacelle::cli {

/// Adds `bag`.
void add_bag_commands(Command& root);
/// Adds `replay`.
void add_replay_command(Command& root);

}  // namespace nacelle::cli
