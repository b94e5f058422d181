// SPDX-License-Identifier: Apache-2.0
// A library to be loaded before a program (LD_PRELOAD): it sleeps at random at every lock, wait, read and write, so that threads meet
// in orders that a quiet machine never shows. It changes no result. `./dev test --chaos SEED` runs the tests with it.
//
//   NACELLE_CHAOS=SEED[,ONE_OF[,LONGEST_US]]   one call of ONE_OF (100) sleeps, at most LONGEST_US (2000) microseconds
//
// The same seed gives each thread the same row of sleeps; how threads meet is still the scheduler's.
#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>

namespace {

struct Settings {
  std::uint64_t seed = 0;
  std::uint64_t one_of = 100;
  std::uint64_t longest_us = 2000;
};

std::atomic<bool> is_on{false};
std::atomic<std::uint64_t> threads{0};
Settings settings;

// A child that has not called exec yet may be under a filter that ends it at any system call.
void stop() { is_on = false; }

__attribute__((constructor)) void start() {
  const char* text = std::getenv("NACELLE_CHAOS");
  if (text == nullptr) return;
  unsigned long long seed = 0;
  unsigned long long one_of = settings.one_of;
  unsigned long long longest_us = settings.longest_us;
  if (std::sscanf(text, "%llu,%llu,%llu", &seed, &one_of, &longest_us) < 1 || one_of == 0 || longest_us == 0) {
    std::fprintf(stderr, "NACELLE_CHAOS=%s: write SEED, SEED,ONE_OF or SEED,ONE_OF,LONGEST_US\n", text);
    std::_Exit(2);
  }
  settings = {seed, one_of, longest_us};
  ::pthread_atfork(nullptr, nullptr, stop);
  is_on = true;
}

// Source: splitmix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014).
std::uint64_t next(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

// Initial-exec: the first use of a library's usual thread-local variable may allocate, and thus lock.
__attribute__((tls_model("initial-exec"))) thread_local std::uint64_t row = 0;

void maybe_sleep() {
  if (!is_on.load(std::memory_order_relaxed)) return;
  if (row == 0) row = settings.seed * 0x100000001b3ULL + ++threads;
  if (next(row) % settings.one_of != 0) return;
  const int before = errno;
  const std::uint64_t us = next(row) % settings.longest_us;
  const timespec time{static_cast<time_t>(us / 1000000), static_cast<long>(us % 1000000) * 1000};
  ::clock_nanosleep(CLOCK_MONOTONIC, 0, &time, nullptr);
  errno = before;
}

// The function of the same name that would have been called without this library.
void* following(std::atomic<void*>& known, const char* name) {
  void* function = known.load(std::memory_order_relaxed);
  if (function == nullptr) {
    function = ::dlsym(RTLD_NEXT, name);
    known.store(function, std::memory_order_relaxed);
  }
  return function;
}

}  // namespace

// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name): the C library's names are reserved ones
// The runtime's own locks and waits are futex calls without a function of the C library.
extern "C" __attribute__((visibility("default"))) long syscall(long number, ...) noexcept {
  static std::atomic<void*> known{nullptr};
  va_list rest;
  va_start(rest, number);
  long words[6];
  for (long& word : words) word = va_arg(rest, long);
  va_end(rest);
  if (number == SYS_futex) maybe_sleep();
  return reinterpret_cast<decltype(&syscall)>(following(known, "syscall"))(number, words[0], words[1], words[2],
                                                                           words[3], words[4], words[5]);
}

// NOLINTBEGIN(bugprone-macro-parentheses): they are parameter and argument lists
// Each function differs in its parameters only. `noexcept` as the C library declares them.
#define NACELLE_DELAYED(result, name, parameters, arguments)                     \
  extern "C" __attribute__((visibility("default"))) result name parameters {     \
    static std::atomic<void*> known{nullptr};                                    \
    maybe_sleep();                                                               \
    return reinterpret_cast<decltype(&name)>(following(known, #name)) arguments; \
  }

NACELLE_DELAYED(int, pthread_mutex_lock, (pthread_mutex_t * mutex) noexcept, (mutex))
NACELLE_DELAYED(int, pthread_mutex_unlock, (pthread_mutex_t * mutex) noexcept, (mutex))
NACELLE_DELAYED(int, pthread_rwlock_rdlock, (pthread_rwlock_t * lock) noexcept, (lock))
NACELLE_DELAYED(int, pthread_rwlock_wrlock, (pthread_rwlock_t * lock) noexcept, (lock))
NACELLE_DELAYED(int, pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t* mutex), (condition, mutex))
NACELLE_DELAYED(int, pthread_cond_timedwait, (pthread_cond_t * condition, pthread_mutex_t* mutex, const timespec* end),
                (condition, mutex, end))
NACELLE_DELAYED(int, pthread_cond_clockwait,
                (pthread_cond_t * condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* end),
                (condition, mutex, clock, end))
NACELLE_DELAYED(int, pthread_cond_signal, (pthread_cond_t * condition) noexcept, (condition))
NACELLE_DELAYED(int, pthread_cond_broadcast, (pthread_cond_t * condition) noexcept, (condition))
NACELLE_DELAYED(ssize_t, read, (int file, void* bytes, size_t size), (file, bytes, size))
NACELLE_DELAYED(ssize_t, write, (int file, const void* bytes, size_t size), (file, bytes, size))
NACELLE_DELAYED(ssize_t, sendmsg, (int file, const msghdr* message, int flags), (file, message, flags))
NACELLE_DELAYED(ssize_t, recvmsg, (int file, msghdr* message, int flags), (file, message, flags))
NACELLE_DELAYED(ssize_t, send, (int file, const void* bytes, size_t size, int flags), (file, bytes, size, flags))
NACELLE_DELAYED(ssize_t, recv, (int file, void* bytes, size_t size, int flags), (file, bytes, size, flags))
NACELLE_DELAYED(int, ppoll, (pollfd * files, nfds_t count, const timespec* limit, const sigset_t* signals),
                (files, count, limit, signals))
NACELLE_DELAYED(int, poll, (pollfd * files, nfds_t count, int timeout_ms), (files, count, timeout_ms))
// NOLINTEND(bugprone-macro-parentheses)
// NOLINTEND(readability-inconsistent-declaration-parameter-name)
