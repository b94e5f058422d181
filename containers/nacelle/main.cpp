// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/commands.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/version.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/runtime/thread_guard.hpp"
#include "offline_commands/commands.hpp"
#include "recording_commands/commands.hpp"
#include "robot_commands/commands.hpp"

int main(int argc, char** argv) {
  using namespace nacelle::cli;
  open_missing_standard_streams();
  write_errors_by_whole_lines();
  refuse_oversized_files_without_signal();
  static_cast<void>(nacelle::runtime::guard_threads());
  Command root{"nacelle", "Nacelle: the whole robot in one process"};
  root.note(
      "Exit codes: 0 success, 1 failure, 2 wrong usage, 3 no container is running.\n"
      "Completion: source <(nacelle completion bash), also zsh and fish\n"
      "First steps: nacelle drive          the simulated robot drives a square\n"
      "             nacelle drive --stay   it waits; in another terminal: nacelle topic list, nacelle teleop");
  add_launch_command(root);
  add_container_command(root);
  add_check_commands(root);
  add_import_command(root);
  add_new_command(root);
  add_isolated_command(root);
  add_drive_command(root);
  add_component_commands(root);
  add_lifecycle_commands(root);
  add_faults_command(root);
  add_node_commands(root);
  add_topic_commands(root);
  add_service_unit_commands(add_service_commands(root));
  add_param_commands(root);
  add_action_commands(root);
  add_qos_commands(root);
  add_tf_commands(root);
  add_top_commands(root);
  add_device_commands(root);
  add_doctor_command(root);
  add_ekf_command(root);
  add_estop_command(root);
  add_export_command(root);
  add_security_commands(root);
  add_bag_commands(root);
  add_look_command(root);
  add_replay_command(root);
  add_teleop_command(root);
  add_sim_commands(root);
  add_imu_commands(root);
  add_base_commands(root);
  add_interface_command(root);
  add_xacro_command(root);
  add_completion_command(root);
  return finish_output(run_command_line(root, std::string{"nacelle "} + program_version(), argc, argv));
}
