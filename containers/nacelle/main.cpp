// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "cli/commands.hpp"
#include "cli/interface_command.hpp"
#include "cli/program.hpp"

int main(int argc, char** argv) {
  using namespace nacelle::cli;
  CLI::App app{"Nacelle: the whole robot in one process", "nacelle"};
  app.set_version_flag("--version", "nacelle " NACELLE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 no container is running.\n"
      "First steps: nacelle drive          the simulated robot drives a square\n"
      "             nacelle drive --stay   it waits; in another terminal: nacelle topic list, nacelle teleop");
  int exit_code = kDone;
  add_launch_command(app, exit_code);
  add_container_command(app, exit_code);
  add_check_commands(app, exit_code);
  add_import_command(app, exit_code);
  add_isolated_command(app, exit_code);
  add_drive_command(app, exit_code);
  add_component_commands(app, exit_code);
  add_lifecycle_commands(app, exit_code);
  add_faults_command(app, exit_code);
  add_topic_commands(app, exit_code);
  add_qos_commands(app, exit_code);
  add_estop_command(app, exit_code);
  add_teleop_command(app, exit_code);
  add_sim_commands(app, exit_code);
  add_interface_command(app, exit_code);
  add_xacro_command(app, exit_code);
  add_completion_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // --help and --version come this way too; CLI11's own numbers above 100 mean wrong usage.
    return app.exit(e) == 0 ? kDone : kUsage;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "nacelle: %s\n", e.what());
    return kFailed;
  }
  return exit_code;
}
