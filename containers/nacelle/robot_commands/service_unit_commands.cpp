// SPDX-License-Identifier: Apache-2.0
// nacelle service install|status|logs|remove: a robot as a service of systemd (launch/systemd, docs/supervision.md).
#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/files.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUser = "nacelle";
constexpr const char* kArguments = "NACELLE_ARGUMENTS=";
// Of devices; which of them a machine has depends on its packages.
constexpr std::array<const char*, 5> kGroups{"dialout", "video", "i2c", "gpio", "input"};

struct UnitWish {
  std::string name = "robot", file, root = "/", component;
  std::vector<std::string> arguments;
  bool purge = false, follow = false, stays_stopped = false;
  std::size_t lines = 100;
};

std::string unit_of(const UnitWish& wish) { return "nacelle@" + wish.name + ".service"; }
fs::path folder_of(const UnitWish& wish) { return fs::path{wish.root} / "etc/nacelle" / wish.name; }
bool is_this_system(const UnitWish& wish) { return wish.root == "/"; }

/// Runs a program of the system and waits for its end. Errors: its exit code, or why it did not start.
Result<void, Problem> run_tool(std::vector<std::string> words) {
  std::vector<char*> argv;
  std::string line;
  for (auto& word : words) {
    argv.push_back(word.data());
    line += (line.empty() ? "" : " ") + word;
  }
  argv.push_back(nullptr);
  std::fflush(nullptr);
  pid_t child = 0;
  if (const int failed = ::posix_spawnp(&child, argv[0], nullptr, nullptr, argv.data(), environ); failed != 0)
    return err(Problem{line, std::strerror(failed), "install the package that has it"});
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return err(Problem{line,
                     WIFEXITED(status) ? fmt::format("ended with code {}", WEXITSTATUS(status))
                                       : fmt::format("ended by signal {}", WTERMSIG(status)),
                     "see its output above"});
}

/// Becomes the program. Returns the exit code if that fails.
int become(std::vector<std::string> words) {
  std::vector<char*> argv;
  for (auto& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::fflush(nullptr);
  ::execvp(argv[0], argv.data());
  return complain({words.front(), std::strerror(errno), "this system has no systemd, or its tools are not installed"});
}

Result<void, Problem> check_system(const UnitWish& wish) {
  if (!is_this_system(wish)) return {};
  std::error_code unknown;
  if (!fs::is_directory("/run/systemd/system", unknown))  // as sd_booted(3)
    return err(Problem{
        "service", "systemd does not run on this system",
        "use `nacelle launch FILE --resume` under another supervisor, or --root DIR for the root folder of an image"});
  if (::geteuid() != 0) return err(Problem{"service", "only root may change services", "use sudo"});
  return {};
}

Result<void, Problem> problem_of(const fs::path& path, const std::error_code& code) {
  if (!code) return {};
  return err(Problem{path.string(), code.message(), "may this user write there?"});
}

/// The launch file of the service: one that includes the robot that is installed with Nacelle, or a copy of any other one.
Result<void, Problem> put_launch_file(const UnitWish& wish) {
  const fs::path target = folder_of(wish) / "robot.launch.yaml";
  std::error_code failed;
  if (wish.file.empty() && fs::exists(fs::symlink_status(target, failed))) return {};
  const std::string standard = default_launch_file();
  const fs::path source = wish.file.empty() ? fs::path{standard} : fs::absolute(wish.file);
  if (source.empty())
    return err(Problem{"service", "no launch file is installed", "give one: nacelle service install FILE"});
  if (source.extension() != ".yaml")
    return err(
        Problem{source.string(), "a service needs a .launch.yaml", "include it from one: `- include: {file: ...}`"});
  if (fs::equivalent(source, target, failed)) return {};
  // By its path: files beside it stay beside it, and an update reaches it.
  if (!standard.empty() && fs::equivalent(source, standard, failed))
    return write_whole_file(
        target.string(),
        "# The robot that is installed with Nacelle; add your own to it.\nlaunch:\n- include: {file: " + standard +
            "}\n");
  const auto text = read_regular_file(source.string());
  if (!text) return err(text.error());
  return write_whole_file(target.string(), text.value());
}

/// Keeps what a user has written, apart from the line of the arguments.
Result<void, Problem> put_environment(const UnitWish& wish) {
  const fs::path target = folder_of(wish) / "environment";
  std::error_code failed;
  std::string text = "# Variables of nacelle@" + wish.name +
                     ", as in systemd.exec(5), EnvironmentFile=. To apply a change: systemctl restart nacelle@" +
                     wish.name +
                     "\n# ROS_DOMAIN_ID=7\n# ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET\n"
                     "# Arguments of the launch file: NACELLE_ARGUMENTS=\"name:=value name:=value\"\n";
  if (fs::exists(target, failed)) {
    if (wish.arguments.empty()) return {};
    auto old = read_regular_file(target.string());
    if (!old) return err(old.error());
    text.clear();
    for (std::string_view left = old.value(); !left.empty();) {
      const std::string_view line = left.substr(0, std::min(left.find('\n'), left.size() - 1) + 1);
      if (!line.starts_with(kArguments)) text += line;
      left.remove_prefix(line.size());
    }
    if (!text.empty() && text.back() != '\n') text += '\n';
  }
  if (!wish.arguments.empty()) text += fmt::format("{}\"{}\"\n", kArguments, join(wish.arguments, " "));
  return write_whole_file(target.string(), text);
}

/// systemd splits them at spaces, and takes quotes and '$' for its own.
Result<void, Problem> check_arguments(const UnitWish& wish) {
  for (const auto& word : wish.arguments) {
    if (word.find_first_of(" \t\n\"'\\$%") != std::string::npos)
      return err(Problem{"'" + word + "'", "the arguments of a service have no spaces, quotes, '\\', '$' and '%'",
                         "write the value into the launch file: `- arg: {name: ..., default: ...}`"});
  }
  auto parsed = launch::parse_arguments(wish.arguments);
  return parsed ? Result<void, Problem>{} : err(parsed.error().front());
}

/// The files that a build installed below its own prefix, where systemd does not look.
Result<void, Problem> link_unit() {
  std::error_code unknown;
  for (const char* const folder : {"/etc/systemd/system", "/run/systemd/system", "/usr/local/lib/systemd/system",
                                   "/usr/lib/systemd/system", "/lib/systemd/system"}) {
    if (fs::exists(fs::path{folder} / "nacelle@.service", unknown)) return {};
  }
  const fs::path prefix = fs::path{program_places().program}.parent_path().parent_path();
  const fs::path unit = prefix / "lib/systemd/system/nacelle@.service";
  if (!fs::exists(unit, unknown))
    return err(Problem{unit.string(), "is not installed",
                       "install Nacelle: the package, or `cmake --install build --prefix /usr/local`"});
  return run_tool({"systemctl", "link", unit.string()});
}

Result<void, Problem> make_user() {
  if (::getpwnam(kUser) == nullptr) {
    const fs::path prefix = fs::path{program_places().program}.parent_path().parent_path();
    if (auto made = run_tool({"systemd-sysusers", (prefix / "lib/sysusers.d/nacelle.conf").string()}); !made)
      return made;
  }
  for (const char* const group : kGroups) {
    if (::getgrnam(group) == nullptr) continue;
    if (auto added = run_tool({"usermod", "--append", "--groups", group, kUser}); !added) return added;
  }
  return {};
}

Result<void, Problem> write_files(const UnitWish& wish) {
  std::error_code failed;
  fs::create_directories(folder_of(wish), failed);
  if (auto made = problem_of(folder_of(wish), failed); !made) return made;
  if (auto put = put_launch_file(wish); !put) return put;
  return put_environment(wish);
}

int install(const UnitWish& wish) {
  if (auto fine = check_arguments(wish); !fine) return complain_of_usage(fine.error());
  if (auto fine = check_system(wish); !fine) return complain(fine.error());
  if (auto written = write_files(wish); !written) return complain(written.error());
  // Where it lies now: files beside the old place are not beside the copy.
  const std::string file = (folder_of(wish) / "robot.launch.yaml").string();
  const auto arguments = launch::parse_arguments(wish.arguments);
  if (const auto plan = launch::load_plan(file, arguments.value_or({}), launch_environment(program_places())); !plan) {
    for (const auto& problem : plan.error()) complain(problem);
    return complain({file, "is not usable as it is, so the service is not enabled",
                     "copy the files that it names to " + folder_of(wish).string() + ", and install again"});
  }
  print_text("wrote %s\n", folder_of(wish).c_str());
  if (!is_this_system(wish)) {
    if (auto done = run_tool({"systemctl", "--root=" + fs::absolute(wish.root).string(), "enable", unit_of(wish)});
        !done)
      return complain(done.error());
    return kDone;
  }
  if (auto done = make_user(); !done) return complain(done.error());
  if (auto done = link_unit(); !done) return complain(done.error());
  if (auto done = run_tool({"systemctl", "enable", unit_of(wish)}); !done) return complain(done.error());
  if (!wish.stays_stopped) {
    if (auto done = run_tool({"systemctl", "restart", unit_of(wish)}); !done) return complain(done.error());
    print_text("%s runs, and starts at boot\n", unit_of(wish).c_str());
  }
  const char* const caller = std::getenv("SUDO_USER");
  print_text("To use nacelle without sudo: sudo usermod -aG %s %s, then log in again\n", kUser,
             caller == nullptr ? "USER" : caller);
  return kDone;
}

int remove(const UnitWish& wish) {
  if (auto fine = check_system(wish); !fine) return complain(fine.error());
  std::vector<std::string> disable{"systemctl", "disable", unit_of(wish)};
  disable.insert(disable.begin() + 1, is_this_system(wish) ? "--now" : "--root=" + fs::absolute(wish.root).string());
  if (auto done = run_tool(disable); !done) return complain(done.error());
  std::error_code failed;
  if (!wish.purge) {
    if (fs::exists(folder_of(wish), failed)) print_text("kept %s; --purge removes it\n", folder_of(wish).c_str());
    return kDone;
  }
  fs::remove_all(folder_of(wish), failed);
  if (auto gone = problem_of(folder_of(wish), failed); !gone) return complain(gone.error());
  print_text("removed %s\n", folder_of(wish).c_str());
  return kDone;
}

int status(const UnitWish& wish) { return become({"systemctl", "--no-pager", "status", unit_of(wish)}); }

int logs(const UnitWish& wish) {
  std::vector<std::string> words{"journalctl", "--unit", unit_of(wish), "--lines", std::to_string(wish.lines)};
  if (wish.follow) {
    words.emplace_back("--follow");
  } else {
    words.emplace_back("--no-pager");
  }
  if (!wish.component.empty()) words.push_back("NACELLE_COMPONENT=" + wish.component);
  return become(std::move(words));
}

}  // namespace

void add_service_unit_commands(Command& service) {
  auto wish = std::make_shared<UnitWish>();
  const auto add = [&](const char* name, const char* what) -> Command& {
    Command& command = service.add(name, what);
    command.option("--name", wish->name, "the robot's name: nacelle@NAME.service, /etc/nacelle/NAME")
        .with_default()
        .checked(wrong_container_name);
    return command;
  };
  const auto add_root = [&](Command& command) {
    command.option("--root", wish->root, "the root folder of an image, in place of this system's")
        .value("DIR")
        .names_a(Names::File);
  };

  Command& install_command =
      add("install", "run a launch file as a service of systemd, from now on and from each boot on");
  install_command
      .option("file", wish->file, "a .launch.yaml file (default: what is there, or the robot that is installed)")
      .names_a(Names::File);
  install_command.option("arguments", wish->arguments, "name:=value for the file's arguments");
  install_command.flag("--no-start", wish->stays_stopped, "only enable it: it starts at the next boot");
  add_root(install_command);
  install_command.note(
      "The file is copied to /etc/nacelle/NAME/robot.launch.yaml; variables are in /etc/nacelle/NAME/environment.");
  install_command.runs([wish] { return install(*wish); });

  Command& status_command = add("status", "show whether the service of a robot runs, and its last lines");
  status_command.runs([wish] { return status(*wish); });

  Command& logs_command = add("logs", "show what the service of a robot has logged");
  logs_command.flag("-f,--follow", wish->follow, "print new lines until Ctrl-C");
  logs_command.option("-n,--lines", wish->lines, "how many lines").with_default();
  logs_command.option("--component", wish->component, "only lines of this component's nodes: /lidar")
      .names_a(Names::Node);
  logs_command.runs([wish] { return logs(*wish); });

  Command& remove_command = add("remove", "stop the service of a robot, and start it at boot no more");
  remove_command.flag("--purge", wish->purge, "remove /etc/nacelle/NAME, too");
  add_root(remove_command);
  remove_command.runs([wish] { return remove(*wish); });
}

}  // namespace nacelle::cli
