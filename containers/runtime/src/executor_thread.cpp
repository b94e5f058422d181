// SPDX-License-Identifier: Apache-2.0
#include "executor_thread.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <csignal>
#include <cstring>

#include "nacelle/base/log.hpp"

namespace nacelle::runtime {
namespace {

// Size for a crash record with its back trace.
constexpr std::size_t kSignalStack = 64UL * 1024;

}  // namespace

SignalStack::SignalStack() {
  stack_t now{};
  // A sanitizer gives threads its own.
  if (::sigaltstack(nullptr, &now) != 0 || (now.ss_flags & SS_DISABLE) == 0) return;
  void* const memory = ::mmap(nullptr, kSignalStack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return;
  stack_t mine{};
  mine.ss_sp = memory;
  mine.ss_size = kSignalStack;
  if (::sigaltstack(&mine, nullptr) != 0) {
    ::munmap(memory, kSignalStack);
    return;
  }
  memory_ = memory;
}

SignalStack::~SignalStack() {
  if (memory_ == nullptr) return;
  stack_t none{};
  none.ss_flags = SS_DISABLE;
  ::sigaltstack(&none, nullptr);
  ::munmap(memory_, kSignalStack);
}

void prepare_this_thread(const std::string& name, const ThreadPolicy& policy, bool complain) {
  pthread_setname_np(pthread_self(), name.substr(0, 15).c_str());
  const Logger log{"executor." + name};
  if (policy.priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = policy.priority;
    if (const int code = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); code != 0 && complain) {
      log.warn(
          "no SCHED_FIFO priority {} ({}): running at normal priority; allow it with LimitRTPRIO={} in the service or "
          "CAP_SYS_NICE",
          policy.priority, std::strerror(code), policy.priority);
    }
  }
  if (!policy.cpus.empty()) {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int cpu : policy.cpus) {
      if (cpu >= 0 && cpu < CPU_SETSIZE) CPU_SET(cpu, &set);
    }
    if (const int code = pthread_setaffinity_np(pthread_self(), sizeof set, &set); code != 0 && complain) {
      log.warn("cannot be bound to cpus {} ({}): runs on any; this machine has 0 to {}", fmt::join(policy.cpus, ", "),
               std::strerror(code), sysconf(_SC_NPROCESSORS_CONF) - 1);
    }
  }
}

std::int32_t this_thread_id() { return gettid(); }

clockid_t cpu_clock_of_this_thread() {
  clockid_t clock{};
  return pthread_getcpuclockid(pthread_self(), &clock) == 0 ? clock : CLOCK_THREAD_CPUTIME_ID;
}

Duration cpu_time_of(clockid_t clock) {
  timespec t{};
  if (clock_gettime(clock, &t) != 0) return Duration::zero();
  return std::chrono::seconds(t.tv_sec) + Duration(t.tv_nsec);
}

}  // namespace nacelle::runtime
