// SPDX-License-Identifier: Apache-2.0
#include "supervisor.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "executor_thread.hpp"

namespace nacelle::runtime {
namespace {

// Sent to the supervisor's thread alone, which blocks it. Its number matters only to a debugger.
int wake_signal() { return SIGRTMIN + 7; }
constexpr Duration kForEver = 24h * 365;  // a transition may have no limit

}  // namespace

Supervisor::Supervisor(Executor::Limits limits) : limits_(limits) {
  // Blocked before the thread exists, so that no signal ends the process.
  sigset_t wake, before;
  sigemptyset(&wake);
  sigaddset(&wake, wake_signal());
  ::pthread_sigmask(SIG_BLOCK, &wake, &before);
  thread_ = std::thread([this] { watch(); });
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void Supervisor::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  ::pthread_kill(thread_.native_handle(), wake_signal());
  thread_.join();
}

void Supervisor::add(Executor& executor) {
  executor.set_activity_hook(
      [this, is_shared = executor.is_shared()](MonotonicTime now) { note_start(now, is_shared); });
  const LockGuard lock(mutex_);
  executors_.push_back(&executor);
}

void Supervisor::remove(Executor& executor) {
  const LockGuard lock(mutex_);
  std::erase(executors_, &executor);
}

void Supervisor::note_start(MonotonicTime now, bool is_shared) {
  const Duration limit = is_shared ? limits_.handover_after : limits_.hang_after;
  // Most wake-ups of a robot are 10 ms apart: each puts the timer off.
  const auto is_set = [&](MonotonicTime at) {
    const Duration left = Duration{due_ns_.load(std::memory_order_relaxed)} - at.since_origin;
    return left <= limit && (!is_shared || left > limit / 4 * 3);
  };
  if (is_set(now)) return;
  const LockGuard lock(due_mutex_);
  const MonotonicTime at = SystemClock{}.now();  // an executor's clock may be a test's
  if (is_set(at)) return;
  (is_shared ? handover_due_ : other_due_) = at + limit;
  set_timer();
}

void Supervisor::set_timer() {
  const MonotonicTime due = std::min(handover_due_, other_due_);
  if (due_ns_.load(std::memory_order_relaxed) == due.nanoseconds()) return;
  due_ns_.store(due.nanoseconds(), std::memory_order_relaxed);
  if (!has_timer_) return;
  const auto ns = due == kNever ? 0 : std::max<std::int64_t>(due.nanoseconds(), 1);  // 0 disarms it
  const itimerspec once{{}, {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)}};
  ::timer_settime(timer_, TIMER_ABSTIME, &once, nullptr);
}

void Supervisor::check() {
  {
    // What starts after this and before the check finds no timer, and sets it.
    const LockGuard lock(due_mutex_);
    handover_due_ = other_due_ = kNever;
    due_ns_.store(kNever.nanoseconds(), std::memory_order_relaxed);
  }
  checks_.fetch_add(1, std::memory_order_relaxed);
  Executor::NextCheck next;
  {
    const LockGuard lock(mutex_);
    for (Executor* executor : executors_) {
      const auto of_this = executor->supervise(limits_);
      next.late = std::min(next.late, of_this.late);
      next.other = std::min(next.other, of_this.other);
    }
  }
  const LockGuard lock(due_mutex_);
  const MonotonicTime now = SystemClock{}.now();
  const auto note = [now](MonotonicTime& due, Duration in) {
    if (in < kForEver) due = std::min(due, now + std::max<Duration>(in, 1ms));
  };
  note(handover_due_, next.late);
  note(other_due_, next.other);
  set_timer();
}

void Supervisor::watch() {
  pthread_setname_np(pthread_self(), "supervisor");
  sigevent by_signal{};
  by_signal.sigev_notify = SIGEV_THREAD_ID;
  by_signal.sigev_signo = wake_signal();
  by_signal._sigev_un._tid = this_thread_id();  // glibc has no other name for it
  bool has_timer = false;
  {
    const LockGuard lock(due_mutex_);
    has_timer = has_timer_ = ::timer_create(CLOCK_MONOTONIC, &by_signal, &timer_) == 0;
  }
  sigset_t wake;
  sigemptyset(&wake);
  sigaddset(&wake, wake_signal());
  const auto ns = limits_.handover_after.count();
  const timespec period{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  while (!stopping_) {
    check();
    if (stopping_) break;
    if (has_timer) {
      ::sigwaitinfo(&wake, nullptr);
    } else {
      ::sigtimedwait(&wake, nullptr, &period);
    }
  }
  if (!has_timer) return;
  const LockGuard lock(due_mutex_);
  has_timer_ = false;
  ::timer_delete(timer_);
}

}  // namespace nacelle::runtime
