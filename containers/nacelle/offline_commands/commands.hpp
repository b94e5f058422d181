// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cli/command.hpp"

namespace nacelle::cli {

// Each function adds its commands to the program.

/// Adds `check` and `params`.
void add_check_commands(Command& root);
void add_import_command(Command& root);
void add_new_command(Command& root);
void add_device_commands(Command& root);
void add_doctor_command(Command& root);
/// Adds `doctor net`.
void add_doctor_net_command(Command& doctor);
void add_qos_commands(Command& root);
void add_security_commands(Command& root);
void add_xacro_command(Command& root);
void add_completion_command(Command& root);

}  // namespace nacelle::cli
