// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

#include "nacelle/base/time.hpp"

namespace nacelle::bench {

/// When the stick of the benchmark moves, and where to: known to both ends, so that a command at the wheels says which move it is of.
///
/// Move k is at first + k * period. It goes to one of 64 speeds, so that the same one comes back after 64 moves only.
struct Schedule {
  MonotonicTime first{};
  Duration period = 33ms;  ///< No multiple of the base's period, so that a move comes at every phase of it.
  std::uint64_t moves = 0;

  static constexpr double kFullSpeed_mps = 0.5;
  static constexpr std::uint64_t kSpeeds = 64;
  static constexpr const char* kVariable = "NACELLE_BENCH_STICK";

  [[nodiscard]] MonotonicTime at(std::uint64_t move) const { return first + period * static_cast<std::int64_t>(move); }
  /// Share of the full speed; never 0.
  [[nodiscard]] static double share(std::uint64_t move) {
    return static_cast<double>(move % kSpeeds + 1) / static_cast<double>(kSpeeds);
  }

  [[nodiscard]] std::string text() const {
    return std::to_string(first.nanoseconds()) + " " + std::to_string(period.count()) + " " + std::to_string(moves);
  }
  /// Of the environment, where the program leaves it for the plugin.
  [[nodiscard]] static std::optional<Schedule> of_environment() {
    const char* const text = std::getenv(kVariable);
    if (text == nullptr) return std::nullopt;
    char* rest = nullptr;
    Schedule schedule;
    schedule.first = MonotonicTime{Duration{std::strtoll(text, &rest, 10)}};
    schedule.period = Duration{std::strtoll(rest, &rest, 10)};
    schedule.moves = std::strtoull(rest, &rest, 10);
    return schedule;
  }
};

}  // namespace nacelle::bench
