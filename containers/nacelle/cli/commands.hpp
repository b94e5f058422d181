// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "command.hpp"

namespace nacelle::cli {

// Each function adds its commands to the program.

/// Adds `check` and `params`.
void add_check_commands(Command& root);
void add_import_command(Command& root);
void add_launch_command(Command& root);
void add_container_command(Command& root);
void add_faults_command(Command& root);
/// Adds the hidden command that a container runs for `isolate: process`. Internal.
void add_isolated_command(Command& root);
void add_doctor_command(Command& root);
/// Adds `doctor net`.
void add_doctor_net_command(Command& doctor);
void add_export_command(Command& root);
void add_drive_command(Command& root);
void add_component_commands(Command& root);
void add_lifecycle_commands(Command& root);
void add_interface_command(Command& root);
void add_node_commands(Command& root);
void add_param_commands(Command& root);
void add_service_commands(Command& root);
void add_tf_commands(Command& root);
void add_topic_commands(Command& root);
void add_action_commands(Command& root);
void add_qos_commands(Command& root);
void add_estop_command(Command& root);
void add_security_commands(Command& root);
void add_teleop_command(Command& root);
void add_sim_commands(Command& root);
/// Adds `streams` and `top`.
void add_watch_commands(Command& root);
void add_xacro_command(Command& root);
void add_completion_command(Command& root);

}  // namespace nacelle::cli
