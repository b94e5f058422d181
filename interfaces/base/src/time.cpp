// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/time.hpp"

#include <ctime>

namespace nacelle {
namespace {

Duration read_clock(clockid_t id) {
  timespec t{};
  clock_gettime(id, &t);
  return std::chrono::seconds{t.tv_sec} + std::chrono::nanoseconds{t.tv_nsec};
}

}  // namespace

MonotonicTime SystemClock::now() const { return {read_clock(CLOCK_MONOTONIC)}; }
WallTime SystemClock::wall_now() const { return {read_clock(CLOCK_REALTIME)}; }

}  // namespace nacelle
