// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/futex.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <ctime>

namespace nacelle::runtime {
namespace {

long futex(const std::atomic<std::uint32_t>& word, int operation, std::uint32_t value, const timespec* timeout) {
  static_assert(sizeof(word) == sizeof(std::uint32_t));
  return syscall(SYS_futex, reinterpret_cast<const std::uint32_t*>(&word), operation | FUTEX_PRIVATE_FLAG, value,
                 timeout, nullptr, FUTEX_BITSET_MATCH_ANY);
}

}  // namespace

void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected) {
  futex(word, FUTEX_WAIT_BITSET, expected, nullptr);
}

void futex_wait_until(const std::atomic<std::uint32_t>& word, std::uint32_t expected, MonotonicTime deadline) {
  const auto ns = deadline.nanoseconds();
  const timespec t{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  // The bit-set form takes an absolute time of CLOCK_MONOTONIC, so an interrupted sleep does not drift.
  futex(word, FUTEX_WAIT_BITSET, expected, &t);
}

void futex_wait_until(const Clock& clock, const std::atomic<std::uint32_t>& word, std::uint32_t expected,
                      MonotonicTime deadline) {
  const Duration left = std::min<Duration>(20ms, deadline - clock.now());
  futex_wait_until(word, expected, SystemClock{}.now() + left);
}

void futex_wake(const std::atomic<std::uint32_t>& word, int count) {
  futex(word, FUTEX_WAKE, static_cast<std::uint32_t>(count), nullptr);
}

void FutexMutex::lock_slowly() {
  while (state_.exchange(kContended, std::memory_order_acquire) != kFree) futex_wait(state_, kContended);
}

}  // namespace nacelle::runtime
