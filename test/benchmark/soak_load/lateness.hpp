// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "nacelle/base/time.hpp"

namespace nacelle::soak {

struct Lateness {
  Duration late{};            ///< Behind the tick's due time.
  Duration waited_for_cpu{};  ///< How long the timer's threads were ready without a CPU since its last tick.
};

/// Measures how late a timer's ticks are on its grid, which skips missed ticks, and how long the scheduler held up the threads that
/// run it. An executor has several threads, and the next tick does not show which of them was held up. Threads: that of the ticks.
class LatenessMeter {
 public:
  void restart(MonotonicTime now, Duration period) {
    due_ = now + period;
    period_ = period;
  }
  Lateness tick(MonotonicTime now) {
    // An early tick shows that the grid lies before the one assumed.
    if (now < due_) due_ = now;
    const Lateness lateness{now - due_, note_waits()};
    due_ += period_ * (lateness.late / period_ + 1);
    return lateness;
  }

 private:
  struct Thread {
    pid_t id = 0;
    Duration waited{};
  };
  Duration note_waits() {
    const pid_t me = ::gettid();
    const auto known = [this](pid_t id) { return std::ranges::find(threads_, id, &Thread::id); };
    if (known(me) == threads_.end() && known(0) != threads_.end()) *known(0) = {me, waited_for_cpu(me)};
    Duration sum{};
    for (Thread& thread : threads_) {
      if (thread.id == 0) break;
      const Duration waited = waited_for_cpu(thread.id);
      sum += waited - std::exchange(thread.waited, waited);
    }
    return sum;
  }
  // How long a thread of this process has been ready without a CPU, since its start; 0 where the kernel does not say.
  static Duration waited_for_cpu(pid_t thread) {
    char text[64];
    std::snprintf(text, sizeof text, "/proc/self/task/%d/schedstat", thread);
    const int file = ::open(text, O_RDONLY | O_CLOEXEC);
    if (file < 0) return {};
    const ssize_t length = ::read(file, text, sizeof text - 1);
    ::close(file);
    if (length <= 0) return {};
    text[length] = '\0';
    char* rest = text;
    std::strtoll(text, &rest, 10);  // time on the CPU
    return Duration{std::strtoll(rest, nullptr, 10)};
  }

  MonotonicTime due_;
  Duration period_{};
  std::array<Thread, 8> threads_{};
};

}  // namespace nacelle::soak
