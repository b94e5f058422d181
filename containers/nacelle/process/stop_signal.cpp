// SPDX-License-Identifier: Apache-2.0
#include "process/stop_signal.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>

#include "nacelle/base/expect.hpp"

namespace nacelle::process {
namespace {

// A signal handler has no user argument, so its data is static, and lock-free.
constexpr int kRequest = -1;
std::atomic<int> first_signal{0};
std::atomic<int> signals_seen{0};
std::atomic<void (*)() noexcept> emergency_exit{nullptr};
std::array<int, 2> pipe_ends{-1, -1}, reload_ends{-1, -1};
std::atomic<int> null_device{-1};  // open while a full output is to be dropped
constexpr std::array<int, 4> kSignals{SIGINT, SIGTERM, SIGHUP, SIGQUIT};
std::array<struct sigaction, kSignals.size()> before{};
struct sigaction pipe_before {};
static_assert(std::atomic<int>::is_always_lock_free);

void write_byte(int descriptor) noexcept {
  const int saved = errno;
  const char byte = 1;
  static_cast<void>(!::write(descriptor, &byte, 1));
  errno = saved;
}

void wake(int number) noexcept {
  int none = 0;
  first_signal.compare_exchange_strong(none, number);
  write_byte(pipe_ends[1]);
}

void on_reload(int /*number*/) { write_byte(reload_ends[1]); }

/// A write() that the signal interrupts is restarted (SA_RESTART), with the new target of the descriptor.
void drop_full_output() noexcept {
  const int sink = null_device.load();
  if (sink < 0) return;
  const int saved = errno;
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  if (::poll(&output, 1, 0) == 0) ::dup2(sink, STDOUT_FILENO);
  errno = saved;
}

void on_signal(int number) {
  wake(number);
  drop_full_output();
  if (signals_seen.fetch_add(1) + 1 <= StopSignal::kGracefulSignals) return;
  if (auto* const leave = emergency_exit.load(); leave != nullptr) leave();
  ::_exit(128 + number);
}

}  // namespace

StopSignal::StopSignal(void (*emergency)() noexcept, FullOutput output, Hangup hangup) {
  NACELLE_EXPECT(pipe_ends[0] < 0, "one StopSignal per process at a time");
  first_signal = 0;
  signals_seen = 0;
  emergency_exit = emergency;
  NACELLE_EXPECT(::pipe2(pipe_ends.data(), O_CLOEXEC | O_NONBLOCK) == 0, "two descriptors are free");
  if (output == FullOutput::Dropped) null_device = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    ::sigaction(kSignals[i], &action, &before[i]);
    // Under nohup the end of the terminal must not end the robot.
    if (kSignals[i] == SIGHUP && before[i].sa_handler == SIG_IGN) ::sigaction(SIGHUP, &before[i], nullptr);
  }
  if (hangup == Hangup::Reload) {
    NACELLE_EXPECT(::pipe2(reload_ends.data(), O_CLOEXEC | O_NONBLOCK) == 0, "two descriptors are free");
    action.sa_handler = on_reload;
    ::sigaction(SIGHUP, &action, nullptr);
  }
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  ::sigaction(SIGPIPE, &ignore, &pipe_before);
}

StopSignal::~StopSignal() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &before[i], nullptr);
  ::sigaction(SIGPIPE, &pipe_before, nullptr);
  emergency_exit = nullptr;
  if (const int sink = null_device.exchange(-1); sink >= 0) ::close(sink);
  for (auto* const ends : {&pipe_ends, &reload_ends}) {
    for (int& end : *ends) {
      if (end >= 0) ::close(end);
      end = -1;
    }
  }
}

int StopSignal::descriptor() const { return pipe_ends[0]; }
int StopSignal::reload_descriptor() const { return reload_ends[0]; }

void StopSignal::take_reload() const {
  std::array<char, 64> bytes{};
  while (::read(reload_ends[0], bytes.data(), bytes.size()) > 0) continue;
}

int StopSignal::number() const { return first_signal.load(); }

const char* StopSignal::name() const {
  switch (number()) {
    case SIGINT: return "SIGINT";
    case SIGTERM: return "SIGTERM";
    case SIGHUP: return "SIGHUP";
    case SIGQUIT: return "SIGQUIT";
    default: return "a request";
  }
}

void StopSignal::raise_by_request() const { wake(kRequest); }

}  // namespace nacelle::process
