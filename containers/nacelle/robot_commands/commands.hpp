// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/command.hpp"

namespace nacelle::cli {

// Each function adds its commands to the program.

void add_launch_command(Command& root);
void add_container_command(Command& root);
void add_faults_command(Command& root);
/// Adds the hidden command that a container runs for `isolate: process`. Internal.
void add_isolated_command(Command& root);
void add_export_command(Command& root);
void add_drive_command(Command& root);
void add_ekf_command(Command& root);
void add_component_commands(Command& root);
void add_estop_command(Command& root);
void add_look_command(Command& root);
void add_teleop_command(Command& root);
void add_sim_commands(Command& root);
/// Adds `install`, `status`, `logs` and `remove` to the command `service`.
void add_service_unit_commands(Command& service);
/// Adds `streams` and `top`.
void add_top_commands(Command& root);

}  // namespace nacelle::cli
