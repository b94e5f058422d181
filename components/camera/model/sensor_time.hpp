// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::camera {

/// How far a stamp may lie ahead of now, and how old it may be.
inline constexpr Duration kStampSlack = 1ms, kOldestStamp = 10s;

/// Returns the age of a frame by libcamera's SensorTimestamp; nothing if the stamp makes no sense on either clock.
///
/// The stamp is defined as nanoseconds of CLOCK_BOOTTIME, and pipelines whose driver stamps by CLOCK_MONOTONIC pass that on. The two
/// differ by the time that the computer was suspended; the clock by which the frame is younger is taken.
/// Source: libcamera 0.4, controls::SensorTimestamp.
/// Units: all in ns; `now_ns` of CLOCK_MONOTONIC, `suspended_ns` what CLOCK_BOOTTIME is ahead of it.
[[nodiscard]] inline std::optional<Duration> age_of(std::int64_t stamp_ns, std::int64_t now_ns,
                                                    std::int64_t suspended_ns) {
  for (const std::int64_t age_ns : {now_ns - stamp_ns, now_ns + suspended_ns - stamp_ns}) {
    const Duration age{age_ns};
    if (age >= -kStampSlack && age <= kOldestStamp) return age;
  }
  return std::nullopt;
}

}  // namespace nacelle::camera
