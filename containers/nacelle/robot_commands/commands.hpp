// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/command.hpp"

namespace nacelle::cli {

// Each adds its commands to the program.

void add_launch_command(Command& root);
void add_container_command(Command& root);
void add_faults_command(Command& root);
/// What a launch file's `isolate: process` starts; not for people.
void add_isolated_command(Command& root);
void add_export_command(Command& root);
void add_drive_command(Command& root);
void add_component_commands(Command& root);
void add_estop_command(Command& root);
void add_teleop_command(Command& root);
void add_sim_commands(Command& root);
/// `streams` and `top`.
void add_watch_commands(Command& root);

}  // namespace nacelle::cli
