// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/thread_guard.hpp"

#ifdef NACELLE_SANITIZED

namespace nacelle::runtime {
bool guard_threads() noexcept { return false; }
}  // namespace nacelle::runtime

#else

#include <dlfcn.h>
#include <pthread.h>

#include <array>
#include <bit>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <new>

#include "executor_thread.hpp"
#include "nacelle/runtime/crash_record.hpp"

namespace nacelle::runtime {
namespace {

constexpr std::array<int, 5> kFaultSignals{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

// Returns the C library's own function behind the definition below.
template <typename Function>
Function* behind(const char* name) noexcept {
  return std::bit_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

using SetMask = int(int, const sigset_t*, sigset_t*);

// Calls the C library's function with the fault signals removed from the mask, unless it unblocks.
int set_mask(SetMask* real, int how, const sigset_t* set, sigset_t* before) noexcept {
  if (set == nullptr || how == SIG_UNBLOCK) return real(how, set, before);
  sigset_t allowed = *set;
  for (const int number : kFaultSignals) sigdelset(&allowed, number);
  return real(how, &allowed, before);
}

struct ThreadStart {
  void* (*function)(void*);
  void* argument;
};

// Must not be noexcept: pthread_exit() unwinds through it.
void* run_guarded(void* argument) {
  const std::unique_ptr<ThreadStart> given{static_cast<ThreadStart*>(argument)};
  const ThreadStart start = *given;
  const SignalStack stack;
  sigset_t faults;
  sigemptyset(&faults);
  for (const int number : kFaultSignals) sigaddset(&faults, number);
  ::pthread_sigmask(SIG_UNBLOCK, &faults, nullptr);
  return start.function(start.argument);
}

}  // namespace

bool guard_threads() noexcept {
  return ::dlsym(RTLD_DEFAULT, "pthread_create") == std::bit_cast<void*>(&::pthread_create);
}

}  // namespace nacelle::runtime

#define NACELLE_REPLACES_LIBC extern "C" __attribute__((visibility("default")))

NACELLE_REPLACES_LIBC int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*function)(void*),
                                         void* argument) noexcept {
  namespace runtime = nacelle::runtime;
  static auto* const real = runtime::behind<decltype(::pthread_create)>("pthread_create");
  auto* const start = new (std::nothrow) runtime::ThreadStart{function, argument};
  if (start == nullptr) return EAGAIN;
  const int code = real(thread, attributes, runtime::run_guarded, start);
  if (code != 0) delete start;
  return code;
}

NACELLE_REPLACES_LIBC int pthread_sigmask(int how, const sigset_t* set, sigset_t* before) noexcept {
  namespace runtime = nacelle::runtime;
  static auto* const real = runtime::behind<runtime::SetMask>("pthread_sigmask");
  return runtime::set_mask(real, how, set, before);
}

NACELLE_REPLACES_LIBC int sigprocmask(int how, const sigset_t* set, sigset_t* before) noexcept {
  namespace runtime = nacelle::runtime;
  static auto* const real = runtime::behind<runtime::SetMask>("sigprocmask");
  return runtime::set_mask(real, how, set, before);
}

NACELLE_REPLACES_LIBC void exit(int status) noexcept {
  static auto* const real = nacelle::runtime::behind<decltype(::exit)>("exit");
  nacelle::runtime::record_exit("exit", status);
  real(status);
  std::abort();  // it does not return
}

NACELLE_REPLACES_LIBC void quick_exit(int status) noexcept {
  static auto* const real = nacelle::runtime::behind<decltype(::quick_exit)>("quick_exit");
  nacelle::runtime::record_exit("quick_exit", status);
  real(status);
  std::abort();  // it does not return
}

#endif
