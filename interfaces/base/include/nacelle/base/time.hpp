// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <type_traits>

namespace nacelle {

using Duration = std::chrono::nanoseconds;
using namespace std::chrono_literals;  // durations are written 500ms throughout the tree

/// A message's time, as builtin_interfaces/msg/Time: `sec` and `nanosec`.
template <typename T>
concept MessageTime = requires(T& time) {
  time.sec;
  time.nanosec;
};

struct MonotonicLine;
struct WallLine;

/// A point on one time line. Points of two time lines do not compare; the tag is the name of the line.
template <typename TimeLine>
struct TimePoint {
  Duration since_origin{};

  friend auto operator<=>(const TimePoint&, const TimePoint&) = default;
  friend TimePoint operator+(TimePoint t, Duration d) { return {t.since_origin + d}; }
  friend TimePoint operator-(TimePoint t, Duration d) { return {t.since_origin - d}; }
  friend Duration operator-(TimePoint a, TimePoint b) { return a.since_origin - b.since_origin; }
  TimePoint& operator+=(Duration d) {
    since_origin += d;
    return *this;
  }
  [[nodiscard]] std::int64_t nanoseconds() const { return since_origin.count(); }
  /// Converts a WallTime into a message's time: `message.header.stamp = node.now();`
  template <MessageTime T>
  requires std::is_same_v<TimeLine, WallLine>
  operator T() const {  // NOLINT(google-explicit-constructor)
    const auto seconds = std::chrono::floor<std::chrono::seconds>(since_origin);
    T time{};
    time.sec = static_cast<decltype(time.sec)>(seconds.count());
    time.nanosec = static_cast<decltype(time.nanosec)>((since_origin - seconds).count());
    return time;
  }
};

/// CLOCK_MONOTONIC: timers, watchdogs, ages, latencies. Never steps.
using MonotonicTime = TimePoint<MonotonicLine>;
/// Time since the Unix epoch: message stamps (ROS time). May step when NTP first answers.
using WallTime = TimePoint<WallLine>;
/// Returns the time of a message's stamp.
template <MessageTime T>
[[nodiscard]] constexpr WallTime time_of(const T& stamp) {
  return {std::chrono::seconds{stamp.sec} + Duration{stamp.nanosec}};
}

[[nodiscard]] inline double to_seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
[[nodiscard]] inline double to_milliseconds(Duration d) { return to_seconds(d) * 1e3; }
[[nodiscard]] inline Duration from_seconds(double seconds) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
}

/// Reads both time lines.
///
/// Only main() and the tests choose one; everybody else is given a reference, so that a test can tell the time.
/// Threads: const members from any thread. Allocates: nothing.
class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;
  virtual ~Clock() = default;

  [[nodiscard]] virtual MonotonicTime now() const = 0;
  [[nodiscard]] virtual WallTime wall_now() const = 0;
};

/// The kernel's clocks.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] MonotonicTime now() const override;
  [[nodiscard]] WallTime wall_now() const override;
};

}  // namespace nacelle
