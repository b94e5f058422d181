// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "nacelle/base/time.hpp"

namespace nacelle::monitor {

/// Numbered as diagnostic_msgs/DiagnosticStatus.
enum class Level : std::uint8_t { Ok = 0, Warn = 1, Error = 2, Stale = 3 };

/// What is expected of a stream.
struct Expectation {
  double rate_hz = 0.0;    ///< 0: any rate is fine.
  double tolerance = 0.1;  ///< Share of the rate that it may be off before it is a warning; half the rate is an error.
  Duration stale_after = 2s;  ///< Silence of a periodic stream.
  Duration most_age{};        ///< Age of a message that is a warning; zero: any.
  bool periodic = true;       ///< False for commands and latched messages: their silence is no fault.
};

/// What was seen since the last look, and what to think of it.
struct StreamReport {
  Level level = Level::Stale;
  std::string message;
  double rate_hz = 0.0;
  std::uint64_t received = 0;          ///< Since the beginning.
  std::uint64_t lost = 0;              ///< Since the beginning: gaps in the writers' counts.
  std::optional<Duration> oldest;      ///< Greatest age of a message since the last look.
  std::optional<Duration> silent_for;  ///< Since the last message; nothing if there was none.
};

/// Watches one stream: how often messages come, how old they are, and which are missing.
///
/// Threads: one. Allocates: record() nothing.
class StreamWatch {
 public:
  /// The number of writers of one stream that are distinguished; gaps of further ones are not detected.
  static constexpr std::size_t kMostWriters = 16;

  /// `sequence` counts from 1 per writer. `age` is of the header's stamp, for messages that have one.
  void record(MonotonicTime received, std::uint64_t writer, std::uint64_t sequence, std::optional<Duration> age);
  /// Evaluates the messages since the last call (or start()), and restarts the interval.
  [[nodiscard]] StreamReport look(MonotonicTime now, const Expectation& expected);
  /// Starts anew: messages missed during a pause are no gap.
  void start(MonotonicTime now);

 private:
  struct WriterCount {
    std::uint64_t id = 0, last = 0;
  };
  std::array<WriterCount, kMostWriters> writers_{};
  std::size_t writer_count_ = 0;
  MonotonicTime since_, last_;
  std::uint64_t received_ = 0, lost_ = 0, recent_ = 0, recent_lost_ = 0;
  std::optional<Duration> oldest_;
  bool any_ = false;  ///< A message came since start().
};

}  // namespace nacelle::monitor
