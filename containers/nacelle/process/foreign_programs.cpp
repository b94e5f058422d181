// SPDX-License-Identifier: Apache-2.0
#include "process/foreign_programs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "nacelle/base/files.hpp"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX has it in no header

namespace nacelle::process {
namespace {

// Groups that a signal handler may have to kill: written by one thread, read in the handler.
std::array<std::atomic<pid_t>, 64> groups{};

void note_group(pid_t group) {
  for (auto& slot : groups) {
    pid_t free = 0;
    if (slot.compare_exchange_strong(free, group)) return;
  }
}
void forget_group(pid_t group) {
  for (auto& slot : groups) {
    pid_t mine = group;
    slot.compare_exchange_strong(mine, 0);
  }
}

std::vector<std::string> environment_with(
    const std::vector<std::pair<std::string, std::optional<std::string>>>& changes) {
  std::vector<std::string> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text{*entry};
    const std::string_view name = text.substr(0, text.find('='));
    bool changed = false;
    for (const auto& [key, value] : changes) changed = changed || key == name;
    if (!changed) all.emplace_back(text);
  }
  for (const auto& [key, value] : changes) {
    if (value) all.push_back(key + "=" + *value);
  }
  return all;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

std::string describe_exit(int status) {
  if (WIFEXITED(status)) return fmt::format("exited with {}", WEXITSTATUS(status));
  if (WIFSIGNALED(status))
    return fmt::format("killed by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  return "stopped";
}

void kill_all_programs() noexcept {
  for (const auto& slot : groups) {
    const pid_t group = slot.load();
    if (group > 0) ::kill(-group, SIGKILL);
  }
}

ForeignProgram::ForeignProgram(ProgramSpec spec, pid_t pid, int pidfd)
    : spec_(std::move(spec)), pid_(pid), pidfd_(pidfd) {
  note_group(pid_);
}

Result<std::unique_ptr<ForeignProgram>, Problem> ForeignProgram::start(const ProgramSpec& spec) {
  std::vector<std::string> words{spec.path};
  words.insert(words.end(), spec.arguments.begin(), spec.arguments.end());
  std::vector<std::string> variables = environment_with(spec.environment);

  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  sigset_t none, defaults;
  sigemptyset(&none);
  sigemptyset(&defaults);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD, SIGXFSZ}) sigaddset(&defaults, number);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setsigdefault(&attributes, &defaults);
  // Its own group is not the terminal's foreground group: reading the terminal would stop it.
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (spec.output_descriptor >= 0) {
    ::posix_spawn_file_actions_adddup2(&actions, spec.output_descriptor, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, spec.output_descriptor, STDERR_FILENO);
  }
  if (spec.inherited_descriptor >= 0)
    ::posix_spawn_file_actions_adddup2(&actions, spec.inherited_descriptor, kInheritedDescriptor);
  // Not every library closes its own: a program that kept the network's sockets would keep their ports.
  ::posix_spawn_file_actions_addclosefrom_np(&actions, kInheritedDescriptor + (spec.inherited_descriptor >= 0 ? 1 : 0));
  if (!spec.working_directory.empty()) ::posix_spawn_file_actions_addchdir_np(&actions, spec.working_directory.c_str());

  std::vector<char*> arguments = pointers_to(words), environment = pointers_to(variables);
  pid_t pid = -1;
  const int failed =
      ::posix_spawnp(&pid, spec.path.c_str(), &actions, &attributes, arguments.data(), environment.data());
  ::posix_spawn_file_actions_destroy(&actions);
  ::posix_spawnattr_destroy(&attributes);
  if (failed != 0) {
    return err(Problem{"program " + spec.label,
                       fmt::format("'{}' cannot be started ({})", spec.path, std::strerror(failed)),
                       "is it installed, and in PATH?"});
  }
  const int pidfd = static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  return std::unique_ptr<ForeignProgram>{new ForeignProgram{spec, pid, pidfd}};
}

ForeignProgram::~ForeignProgram() {
  if (ended().empty()) {
    ::kill(-pid_, SIGKILL);
    ::kill(pid_, SIGKILL);  // qemu-user starts it without waiting: it may have no group of its own yet
    int status = 0;
    ::waitpid(pid_, &status, 0);
    forget_group(pid_);
  }
  if (pidfd_ >= 0) ::close(pidfd_);
}

std::string ForeignProgram::ended() {
  int status = 0;
  if (!reaped_ && ::waitpid(pid_, &status, WNOHANG) == pid_) {
    reaped_ = true;
    how_ = describe_exit(status);
    // Children that it left behind go with it.
    ::kill(-pid_, SIGKILL);
    forget_group(pid_);
    ::close(pidfd_);
    pidfd_ = -1;
  }
  return how_;
}

Result<void, Problem> ForeignProgram::wait_until_ready(Duration limit, int stop_descriptor, const Clock& clock) {
  if (spec_.ready_file.empty()) return {};
  const std::string where = "program " + spec_.label;
  const MonotonicTime until = clock.now() + limit;
  while (true) {
    // A file with another number is of a killed predecessor.
    constexpr std::size_t kMostDigits = 64;
    const std::string number = read_regular_file(spec_.ready_file, kMostDigits).value_or("");
    if (!number.empty() && std::strtol(number.c_str(), nullptr, 10) == pid_) return {};
    if (const std::string how = ended(); !how.empty())
      return err(Problem{where, "ended before it was ready: " + how, "see its output above"});
    if (clock.now() > until) {
      return err(Problem{where,
                         fmt::format("not ready after {} s ({} did not appear)", to_seconds(limit), spec_.ready_file),
                         "is the machine overloaded?"});
    }
    std::array<pollfd, 2> waits{pollfd{pidfd_, POLLIN, 0}, pollfd{stop_descriptor, POLLIN, 0}};
    ::poll(waits.data(), waits.size(), 2);
    if (waits[1].revents != 0) return err(Problem{where, "interrupted while it was starting", ""});
  }
}

bool ForeignProgram::wait_for_end(Duration limit, const Clock& clock) {
  const MonotonicTime until = clock.now() + limit;
  while (ended().empty()) {
    const Duration left = until - clock.now();
    if (left <= 0ns) return false;
    pollfd wait{pidfd_, POLLIN, 0};
    ::poll(&wait, 1, static_cast<int>(left / 1ms) + 1);
  }
  return true;
}

std::string ForeignProgram::stop(const Clock& clock) {
  // The order of signals of ros2 launch, which ROS programs expect.
  if (!ended().empty()) return how_;
  ::kill(pid_, SIGINT);
  if (wait_for_end(spec_.sigterm_after, clock)) return how_;
  ::kill(-pid_, SIGTERM);
  if (wait_for_end(spec_.sigkill_after, clock)) return how_;
  ::kill(-pid_, SIGKILL);
  static_cast<void>(wait_for_end(5s, clock));
  return how_;
}

}  // namespace nacelle::process
