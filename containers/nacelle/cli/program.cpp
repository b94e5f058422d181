// SPDX-License-Identifier: Apache-2.0
#include "cli/program.hpp"

#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "control/other_users.hpp"
#include "control/socket_path.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/problem_json.hpp"
#include "nacelle/qos/profiles.hpp"

namespace nacelle::cli {
namespace {

namespace fs = std::filesystem;

bool in_json = false;  // errors, as the command line asks

fs::path program_path() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored);
}

/// The prefix of an installation; of a build tree, the build directory.
fs::path prefix() { return program_path().parent_path().parent_path(); }
/// Of a build in <source>/build, the source; it has launch files and profiles at its top level.
fs::path source_tree() { return prefix().parent_path(); }

std::vector<std::string> split_path(const char* text) {
  std::vector<std::string> parts;
  const std::string_view all = text != nullptr ? text : "";
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = std::min(all.find(':', begin), all.size());
    if (end > begin) parts.emplace_back(all.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// A build directory anywhere knows its source from CMake's cache.
fs::path source_of_build() {
  std::error_code ignored;
  if (fs::exists(source_tree() / "launch" / "robot.launch.yaml", ignored)) return source_tree();
  if (FILE* const cache = std::fopen((prefix() / "CMakeCache.txt").c_str(), "re"); cache != nullptr) {
    constexpr std::string_view kKey = "CMAKE_HOME_DIRECTORY:INTERNAL=";
    char line[4096];
    std::string found;
    while (found.empty() && std::fgets(line, sizeof line, cache) != nullptr) {
      const std::string_view text{line};
      if (text.rfind(kKey, 0) == 0) found = std::string{text.substr(kKey.size(), text.find('\n') - kKey.size())};
    }
    std::fclose(cache);
    return found;
  }
  return {};
}

std::string first_existing(const std::vector<fs::path>& candidates) {
  std::error_code ignored;
  for (const auto& candidate : candidates) {
    if (fs::exists(candidate, ignored)) return candidate.string();
  }
  return {};
}

/// Packages of ROS's form: those with a package.xml.
std::vector<std::string> packages_in(const std::vector<std::string>& prefixes) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& prefix : prefixes) {
    for (const auto& entry : fs::directory_iterator(fs::path{prefix} / "share", ignored)) {
      if (fs::exists(entry.path() / "package.xml", ignored)) names.push_back(entry.path().filename().string());
    }
  }
  return names;
}

}  // namespace

void complain_in_json() { in_json = true; }

int complain(const Problem& problem) {
  using nlohmann::json;
  const std::string line = in_json ? json{{"problem", problem}}.dump(-1, ' ', false, json::error_handler_t::replace)
                                   : "nacelle: " + problem.text();
  std::fprintf(stderr, "%s\n", line.c_str());
  return kFailed;
}

int complain_of_usage(const Problem& problem) {
  complain(problem);
  return kUsage;
}

std::vector<fs::path> message_library_directories() {
  const fs::path libraries = prefix() / "lib";
  std::vector<fs::path> directories{libraries};
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(libraries, unknown)) {
    // Debian's multi-architecture folders: lib/aarch64-linux-gnu.
    if (entry.path().filename().string().ends_with("-linux-gnu")) directories.push_back(entry.path());
  }
  return directories;
}

loading::ProgramPlaces program_places() {
  loading::ProgramPlaces places;
  places.program = program_path().string();
  places.component_folders = split_path(std::getenv("NACELLE_COMPONENT_PATH"));
  // Beside ../lib the folder of the architecture, where Debian puts libraries; message libraries lie in the same ones.
  places.message_folders = message_library_directories();
  for (const auto& folder : places.message_folders) places.component_folders.push_back((folder / "nacelle").string());
  places.prefixes = split_path(std::getenv("NACELLE_PREFIX_PATH"));
  places.prefixes.push_back(prefix().string());
  return places;
}

int complain_of_no_plugins(const loading::ProgramPlaces& places) {
  return complain({"components", "no plugin is installed in " + join(places.component_folders, ":"),
                   "set NACELLE_COMPONENT_PATH to where they are"});
}

std::string default_launch_file() {
  std::vector<fs::path> candidates{prefix() / "share/nacelle_launch/robot.launch.yaml",
                                   prefix() / "share/nacelle_launch/launch/robot.launch.yaml"};
  if (const fs::path source = source_of_build(); !source.empty())
    candidates.push_back(source / "launch/robot.launch.yaml");
  return first_existing(candidates);
}

std::string template_folder() {
  std::vector<fs::path> candidates{prefix() / "share/nacelle/templates"};
  if (const fs::path source = source_of_build(); !source.empty())
    candidates.push_back(source / "docs/examples/packages");
  return first_existing(candidates);
}

launch::Environment launch_environment(const loading::ProgramPlaces& places) {
  launch::Environment environment = launch::system_environment();
  const fs::path source = source_of_build();
  environment.find_package_share = [prefixes = places.prefixes,
                                    source](const std::string& package) -> std::optional<std::string> {
    std::vector<fs::path> candidates;
    candidates.reserve(prefixes.size() + 1);
    for (const auto& prefix : prefixes) candidates.push_back(fs::path{prefix} / "share" / package);
    if (!source.empty() && package == "nacelle_launch") candidates.push_back(source / "launch");
    std::string found = first_existing(candidates);
    if (found.empty()) return std::nullopt;
    return found;
  };
  environment.packages = packages_in(places.prefixes);
  if (!source.empty()) environment.packages.emplace_back("nacelle_launch");
  std::vector<fs::path> profiles{prefix() / "share/nacelle_qos/profiles/robot.yaml"};
  if (!source.empty()) profiles.push_back(source / "qos_profiles/profiles/robot.yaml");
  if (const std::string file = first_existing(profiles); !file.empty()) {
    if (auto loaded = load_profiles(file)) {
      environment.profiles = std::move(loaded).value();
    } else {
      for (const auto& problem : loaded.error()) complain(problem);
    }
  }
  environment.anonymous_suffix = std::to_string(::getpid());
  return environment;
}

std::vector<control::FoundContainer> trusted_containers() {
  std::vector<Problem> ignored;
  auto found = control::running_containers(control::socket_places_from_environment(), &ignored);
  for (const Problem& problem : ignored) complain(problem);
  return found;
}

Result<control::Client, int> connect(const Whom& whom) {
  if (const auto wrong = whom.misuse()) return err(complain_of_usage(*wrong));
  if (whom.is_remote()) {
    auto client = whom.connect_remotely(message_library_directories());
    if (!client) return err(complain(client.error()));
    return std::move(client).value();
  }
  return connect(whom.container);
}

Result<control::Client, int> connect(const std::string& container_option) {
  std::optional<std::string> wanted;
  if (!container_option.empty()) {
    wanted = container_option;
  } else if (const char* const variable = std::getenv("NACELLE_CONTAINER"); variable != nullptr && *variable != '\0') {
    wanted = variable;
  }
  const auto running = trusted_containers();
  auto found = control::choose_container(running, wanted);
  if (!found) {
    Problem problem = found.error();
    if (running.empty()) {
      const auto others = control::containers_of_others(read_regular_file("/proc/net/unix").value_or(""), ::geteuid());
      if (!others.empty()) problem = control::problem_of_others(others);
    }
    complain(problem);
    return err(found.error().code == NameFault::Ambiguous ? kUsage : kNoContainer);
  }
  auto client = control::Client::connect(found.value().path);
  if (!client) {
    complain(client.error());
    return err(kNoContainer);
  }
  return std::move(client).value();
}

std::string wrong_container_name(const std::string& name) {
  const auto valid = control::validate_container_name(name);
  return valid ? std::string{} : valid.error().text();
}

void add_container_option(Command& command, std::string& container) {
  command.option("--container", container, "which container, if several are running (or NACELLE_CONTAINER)");
}

void add_common_options(Command& command, std::string& container, bool& as_json) {
  add_container_option(command, container);
  command.flag("--json", as_json, "print JSON");
}

void add_common_options(Command& command, Whom& whom, bool& as_json) {
  add_common_options(command, whom.container, as_json);
  whom.add_options(command);
}

void die_with_parent(long parent_pid) {
  if (parent_pid <= 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent_pid) ::raise(SIGTERM);
}

}  // namespace nacelle::cli
