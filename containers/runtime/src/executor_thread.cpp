// SPDX-License-Identifier: Apache-2.0
#include "executor_thread.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <cstring>

#include "nacelle/base/log.hpp"

namespace nacelle::runtime {

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
