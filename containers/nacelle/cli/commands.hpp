// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace nacelle::cli {

// Each adds its commands to the program. They run when `app` has parsed its arguments, and leave the process's exit code
// (program.hpp) in `exit_code`; what went wrong has been said on stderr then.

/// `check` and `params`.
void add_check_commands(CLI::App& app, int& exit_code);
void add_import_command(CLI::App& app, int& exit_code);
void add_launch_command(CLI::App& app, int& exit_code);
void add_container_command(CLI::App& app, int& exit_code);
void add_faults_command(CLI::App& app, int& exit_code);
/// What a launch file's `isolate: process` starts; not for people.
void add_isolated_command(CLI::App& app, int& exit_code);
void add_drive_command(CLI::App& app, int& exit_code);
void add_component_commands(CLI::App& app, int& exit_code);
void add_lifecycle_commands(CLI::App& app, int& exit_code);
void add_topic_commands(CLI::App& app, int& exit_code);
void add_qos_commands(CLI::App& app, int& exit_code);
void add_estop_command(CLI::App& app, int& exit_code);
void add_teleop_command(CLI::App& app, int& exit_code);
void add_sim_commands(CLI::App& app, int& exit_code);
void add_xacro_command(CLI::App& app, int& exit_code);
void add_completion_command(CLI::App& app, int& exit_code);

}  // namespace nacelle::cli
