// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/command.hpp"

namespace nacelle::cli {

// Each function adds its commands to the program.

void add_lifecycle_commands(Command& root);
void add_interface_command(Command& root);
void add_node_commands(Command& root);
void add_param_commands(Command& root);
/// Returns the command `service`.
Command& add_service_commands(Command& root);
void add_tf_commands(Command& root);
void add_topic_commands(Command& root);
void add_action_commands(Command& root);
void add_imu_commands(Command& root);

}  // namespace nacelle::cli
