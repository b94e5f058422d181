// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include "ekf/component/input.hpp"
#include "nacelle/base/log.hpp"

namespace nacelle::ekf {

/// Logs once per part that some of its measurements are older than the history, once that the history is shorter than it should be, and
/// without a history once that a part is late all the time, with the length that it needs.
/// Threads: one. Allocates: only to log.
class LateWatch {
 public:
  LateWatch(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter);
  /// Looks at what happened since the last look; call about once a second.
  void look(const std::vector<std::unique_ptr<Input>>& inputs, const Filter& filter, const Logger& logger);

 private:
  struct Seen {
    PartStats stats;
    Duration most_late{};
    int late_looks{0};
    bool told_old{false}, told_late{false};
  };
  void look_at_too_old(const Input::Part& part, const PartStats& now, Seen& seen, const History& history,
                       const Logger& logger) const;
  void look_at_late(const Input::Part& part, const PartStats& now, Seen& seen, Duration period,
                    const Logger& logger) const;
  std::vector<Seen> seen_;
  bool told_short_{false};
};

/// "late measurements go back up to 1 s: room for 300 (1.3 MB), at most for 4096 (17.2 MB)"
[[nodiscard]] std::string in_words(const History& history);

/// The history as a status of its own; nothing without one. Allocates: yes.
void write_history_diagnostics(const Filter& filter, const std::string& node,
                               diagnostic_msgs::msg::DiagnosticArray& out);

}  // namespace nacelle::ekf
