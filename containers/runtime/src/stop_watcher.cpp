// SPDX-License-Identifier: Apache-2.0
#include "stop_watcher.hpp"

#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>

#include "nacelle/base/log.hpp"
#include "safe_stop.hpp"

namespace nacelle::runtime {
namespace {

struct StopTable {
  std::array<WatchedStop, StopWatcher::kMost> stops;
};
std::atomic<StopTable*> stop_table{nullptr};
static_assert(std::atomic<StopTable*>::is_always_lock_free);

constexpr int kParentEnded = SIGUSR1;

// The commands in a line's output queue are from a process that has ended; the stop replaces them.
bool write_watched(const WatchedStop& stop, int descriptor) noexcept {
  const ByteView frame{stop.frame.data(), stop.length};
  if (write_stop(descriptor, frame, stop.bytes_a_write)) return true;
  ::tcflush(descriptor, TCOFLUSH);
  return write_stop(descriptor, frame, stop.bytes_a_write);
}

// A blocked line must not keep the watcher alive, and with it the container's descriptors.
void say_to_stderr(pid_t container, unsigned written) noexcept {
  pollfd wait{STDERR_FILENO, POLLOUT, 0};
  if (::poll(&wait, 1, 0) != 1 || (wait.revents & POLLOUT) == 0) return;
  std::array<char, 160> line{};
  const int length =
      std::snprintf(line.data(), line.size(),
                    "nacelle: process %d has ended without an orderly end; stop frames written by its watcher: %u\n",
                    static_cast<int>(container), written);
  if (length > 0) static_cast<void>(!::write(STDERR_FILENO, line.data(), static_cast<std::size_t>(length)));
}

// In the watcher's process: a copy of the container's memory, in which other threads may have held any lock. System calls only.
[[noreturn]] void watch(pid_t container, const StopTable& table) noexcept {
  ::setsid();
  ::prctl(PR_SET_NAME, "nacelle_watcher");
  // Fails without the privilege; then the watcher is scheduled like any process.
  sched_param first{};
  first.sched_priority = 1;
  static_cast<void>(::sched_setscheduler(0, SCHED_FIFO, &first));
  ::prctl(PR_SET_PDEATHSIG, kParentEnded);
  sigset_t ended;
  sigemptyset(&ended);
  sigaddset(&ended, kParentEnded);
  // The signal comes when the thread that made the watcher ends; the parent is another one when the last thread has ended.
  while (::getppid() == container) ::sigwaitinfo(&ended, nullptr);
  unsigned written = 0;
  for (const WatchedStop& stop : table.stops) {
    const int descriptor = stop.descriptor.load(std::memory_order_acquire);
    if (descriptor >= 0 && write_watched(stop, descriptor)) ++written;
  }
  if (written != 0) say_to_stderr(container, written);
  ::_exit(0);
}

}  // namespace

WatchedStop* watched_stop(std::size_t number) noexcept {
  StopTable* const table = stop_table.load(std::memory_order_acquire);
  return table != nullptr && number < table->stops.size() ? &table->stops[number] : nullptr;
}

StopWatcher::StopWatcher() {
  const auto refused = [](const char* what) {
    Logger("runtime").warn(
        "no watcher process ({}: {}): after SIGKILL or _exit() only the board's own watchdog stops the wheels", what,
        std::strerror(errno));
  };
  void* const memory = ::mmap(nullptr, sizeof(StopTable), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    refused("mmap");
    return;
  }
  auto* const table = new (memory) StopTable;
  const pid_t container = ::getpid();
  sigset_t all, before;
  sigfillset(&all);
  ::sigprocmask(SIG_SETMASK, &all, &before);
  // Like fork(), but with a shared table of open files, and without SIGCHLD at its end.
  process_ = static_cast<pid_t>(::syscall(SYS_clone, CLONE_FILES, nullptr, nullptr, nullptr, nullptr));
  if (process_ == 0) watch(container, *table);
  const int failed = errno;
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  errno = failed;
  if (process_ < 0) {
    refused("clone");
    ::munmap(memory, sizeof(StopTable));
    return;
  }
  stop_table.store(table, std::memory_order_release);
  mirror_safe_stops();
}

StopWatcher::~StopWatcher() {
  if (process_ < 0) return;
  // The memory stays: a thread may be about to write to its copy.
  stop_table.store(nullptr, std::memory_order_release);
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, __WALL) < 0 && errno == EINTR) {}
}

}  // namespace nacelle::runtime
