// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/whom.hpp"
#include "control/client.hpp"
#include "control/socket_path.hpp"
#include "loading/program_places.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/load_plan.hpp"

namespace nacelle::cli {

/// The program's exit codes.
inline constexpr int kDone = 0, kFailed = 1, kUsage = 2, kNoContainer = 3;

/// Prints the problem to stderr, as a line of JSON ({"problem": {...}}, nacelle/base/problem_json.hpp) after
/// complain_in_json(). Returns kFailed.
int complain(const Problem& problem);
/// Makes complain() print JSON, for --json of any command.
void complain_in_json();
/// Reports wrong usage as complain() does. Returns kUsage.
int complain_of_usage(const Problem& problem);

/// Returns the folders of the message packages' libraries, for an installed or freshly built program: ../lib beside the
/// program, and ../lib/<architecture> where Debian puts them.
[[nodiscard]] std::vector<std::filesystem::path> message_library_directories();
/// Returns the folders of the running program, installed or freshly built.
[[nodiscard]] loading::ProgramPlaces program_places();
/// Reports that these places hold no component. Returns kFailed.
int complain_of_no_plugins(const loading::ProgramPlaces& places);
/// Returns the launch file that `nacelle drive` starts by default; empty if there is none.
[[nodiscard]] std::string default_launch_file();
/// Returns the folder of the example packages of which `nacelle new component` makes packages; empty if there is none.
[[nodiscard]] std::string template_folder();
/// Returns the environment of launch files: variables, packages' folders, the robot's QoS profiles.
[[nodiscard]] launch::Environment launch_environment(const loading::ProgramPlaces& places);

/// Returns the running containers that this user may trust (control/trust.hpp). Prints the ignored ones to stderr, with
/// the reason.
[[nodiscard]] std::vector<control::FoundContainer> trusted_containers();

/// Returns a connection as selected by the options: to the nodes of the network with --remote, otherwise to a
/// container: --container, else NACELLE_CONTAINER, else the only one. Errors: the exit code; the error has been printed
/// to stderr.
[[nodiscard]] Result<control::Client, int> connect(const Whom& whom);
/// Returns a connection to a container, for commands that only a container can answer.
[[nodiscard]] Result<control::Client, int> connect(const std::string& container_option);

/// Adds --container and --json, which every command that queries a container has.
void add_container_option(Command& command, std::string& container);
void add_common_options(Command& command, std::string& container, bool& as_json);
/// Adds the same options for a command that can also query the nodes of the network.
void add_common_options(Command& command, Whom& whom, bool& as_json);

/// Returns the error of an invalid container name, or an empty text; for Option::checked().
[[nodiscard]] std::string wrong_container_name(const std::string& name);

/// Makes the kernel send SIGTERM to this process when its parent ends. If the parent has already ended, raises it at
/// once. Does nothing if `parent_pid` is not positive.
void die_with_parent(long parent_pid);

}  // namespace nacelle::cli
