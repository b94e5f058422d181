// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nacelle/base/time.hpp"

namespace nacelle::drive {

/// Computes the messages per second of each stream from the counts of the last two seconds. Pure.
class RateMeter {
 public:
  void note(const std::string& stream, std::uint64_t published, MonotonicTime now);
  /// Returns 0 until two counts are known.
  [[nodiscard]] double hz(const std::string& stream) const;

 private:
  struct Count {
    MonotonicTime at;
    std::uint64_t published;
  };
  std::map<std::string, std::deque<Count>> counts_;
};

/// Shows the progress of a run: on a terminal a block that is redrawn in place, elsewhere a line every few seconds.
/// Threads: one.
class LiveView {
 public:
  LiveView(bool on_terminal, MonotonicTime start) : on_terminal_(on_terminal), start_(start) {}

  /// Returns the time between two updates.
  [[nodiscard]] Duration period() const { return on_terminal_ ? 250ms : 1000ms; }
  /// Shows the state. `stats`: the container's live figures. `activity`: what the drive is doing.
  void show(const nlohmann::json& stats, const std::string& activity, MonotonicTime now);
  /// Removes the block.
  void clear();

  [[nodiscard]] const RateMeter& rates() const { return rates_; }

 private:
  [[nodiscard]] std::string block(const nlohmann::json& stats, const std::string& activity, MonotonicTime now) const;
  [[nodiscard]] std::string line(const nlohmann::json& stats, const std::string& activity, MonotonicTime now) const;

  bool on_terminal_;
  MonotonicTime start_;
  RateMeter rates_;
  std::size_t lines_shown_ = 0;
  std::string last_phase_;
  bool was_active_ = false;  // the last line had an activity
  MonotonicTime last_line_;
};

}  // namespace nacelle::drive
