// SPDX-License-Identifier: Apache-2.0
#include "support/roudi.hpp"

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>

namespace nacelle::test {
namespace {

namespace fs = std::filesystem;

constexpr char kReady = 'r', kForeign = 'f', kNoProgram = 'p', kBroken = 'b';
constexpr char kKill = 'k', kStart = 's', kStop = 't';

[[noreturn]] void die(const char* what) {
  std::perror(what);
  std::_Exit(70);
}

bool somebody_listens() {
  const int probe = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, "/tmp/roudi");
  const bool answered = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(probe);
  return answered;
}

void remove_files() {
  std::error_code ignored;
  const struct group* const group = ::getgrgid(::getegid());
  for (const std::string& name :
       {std::string("/tmp/roudi"), std::string("/tmp/roudi.lock"), std::string("/tmp/iox-unique-roudi.lock"),
        std::string("/dev/shm/iceoryx_mgmt"), std::string("/dev/shm/") + (group != nullptr ? group->gr_name : "")}) {
    if (fs::is_regular_file(name, ignored) || fs::is_socket(name, ignored)) fs::remove(name, ignored);
  }
  // What processes that were killed have left behind.
  for (const auto& entry : fs::directory_iterator("/tmp", ignored)) {
    int pid = 0;
    if (std::sscanf(entry.path().filename().c_str(), "nacelle-%d-", &pid) != 1) continue;
    if (::kill(pid, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), ignored);
  }
}

/// The keeper's side: the daemon and its output.
class Keeper {
 public:
  Keeper(int control, std::string configuration) : control_(control), configuration_(std::move(configuration)) {}

  [[noreturn]] void run() {
    ::setpgid(0, 0);  // a Ctrl-C is for the test; its end is ours
    const int folder = ::open("/dev/shm", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0 || ::flock(folder, LOCK_EX) != 0) die("lock on /dev/shm");
    if (somebody_listens()) answer(kForeign), std::_Exit(0);
    answer(start());
    char word = 0;
    while (::read(control_, &word, 1) == 1) {
      if (word == kKill) end();
      if (word == kStop && ::kill(daemon_, SIGSTOP) == 0)
        ::waitpid(daemon_, nullptr, WUNTRACED);  // it is still while this is answered
      answer(word == kStart ? start() : kReady);
    }
    end();
    remove_files();
    std::_Exit(0);
  }

 private:
  void answer(char word) { static_cast<void>(!::write(control_, &word, 1)); }

  char start() {
    char name[] = "/tmp/nacelle_roudi_XXXXXX";
    const int file = ::mkstemp(name);
    if (file < 0 ||
        ::write(file, configuration_.data(), configuration_.size()) != static_cast<ssize_t>(configuration_.size()))
      die("daemon's configuration");
    ::close(file);
    int says[2];
    if (::pipe2(says, O_CLOEXEC) != 0) die("pipe");
    const pid_t keeper = ::getpid();
    daemon_ = ::fork();
    if (daemon_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (::getppid() != keeper) std::_Exit(0);
      ::dup2(says[1], STDOUT_FILENO);
      ::dup2(says[1], STDERR_FILENO);
      ::execlp("iox-roudi", "iox-roudi", "-l", "off", "-c", name, nullptr);
      std::_Exit(127);
    }
    ::close(says[1]);
    const bool ready = wait_until_ready(says[0]);
    ::unlink(name);
    // The daemon logs nothing more (-l off), so this end stays open and unread until it ends.
    output_ = says[0];
    if (ready) return kReady;
    int status = 0;
    ::waitpid(daemon_, &status, 0);
    daemon_ = 0;
    return WIFEXITED(status) && WEXITSTATUS(status) == 127 ? kNoProgram : kBroken;
  }

  static bool wait_until_ready(int output) {
    std::string said;
    std::array<char, 256> some{};
    while (said.find("ready for clients") == std::string::npos) {
      const ssize_t n = ::read(output, some.data(), some.size());
      if (n <= 0) return false;
      said.append(some.data(), static_cast<std::size_t>(n));
    }
    return true;
  }

  void end() {
    if (daemon_ <= 0) return;
    ::kill(daemon_, SIGKILL);
    ::waitpid(daemon_, nullptr, 0);
    ::close(output_);
    daemon_ = 0;
  }

  int control_;
  std::string configuration_;
  pid_t daemon_ = 0;
  int output_ = -1;
};

std::string configuration_of(const std::vector<ChunkPool>& pools) {
  std::string text = "[general]\nversion = 1\n[[segment]]\n";
  for (const ChunkPool& pool : pools) {
    text +=
        "[[segment.mempool]]\nsize = " + std::to_string(pool.bytes) + "\ncount = " + std::to_string(pool.count) + "\n";
  }
  return text;
}

}  // namespace

std::unique_ptr<RouDi> RouDi::start(const std::vector<ChunkPool>& pools, std::string& why_not) {
  return start_configured(configuration_of(pools), why_not);
}

std::unique_ptr<RouDi> RouDi::start_configured(const std::string& configuration, std::string& why_not) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) die("socketpair");
  std::fflush(nullptr);
  const pid_t keeper = ::fork();
  if (keeper < 0) die("fork");
  if (keeper == 0) {
    ::close(ends[0]);
    Keeper{ends[1], configuration}.run();
  }
  ::close(ends[1]);
  char word = kBroken;
  if (::read(ends[0], &word, 1) != 1) word = kBroken;
  if (word == kReady) return std::unique_ptr<RouDi>(new RouDi(ends[0], keeper));
  ::close(ends[0]);
  ::waitpid(keeper, nullptr, 0);
  why_not = word == kForeign ? "an iox-roudi that is not this test's runs on this machine, and there can be only one"
            : word == kNoProgram ? "the program iox-roudi is not installed (Debian package iceoryx)"
                                 : "iox-roudi does not start here (is /dev/shm writable and larger than 100 MB?)";
  return nullptr;
}

RouDi::~RouDi() {
  ::close(control_);
  ::waitpid(keeper_, nullptr, 0);
}

void RouDi::order(char word) {
  char answer = kBroken;
  if (::write(control_, &word, 1) != 1 || ::read(control_, &answer, 1) != 1 || answer != kReady)
    die("the daemon's keeper");
}

void RouDi::kill() { order(kKill); }
void RouDi::start_again() { order(kStart); }
void RouDi::stop_answering() { order(kStop); }

}  // namespace nacelle::test
