// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include "nacelle/base/log.hpp"
#include "navsat/component/navsat_inputs.hpp"

namespace nacelle::navsat {

/// Logs why messages are not used, once per input and cause until they are used again, and what the alignment waits for.
/// Threads: one. Allocates: only to log, and for the diagnostics.
class NavsatReport {
 public:
  /// `waits_for`: what the alignment of the frames needs; empty once they are aligned. Call about once a second.
  void look(const NavsatStats& now, const std::string& waits_for, const Logger& logger);
  /// The state of the last look.
  void write(const NavsatStats& now, const std::string& waits_for, const std::string& node,
             diagnostic_msgs::msg::DiagnosticArray& out) const;

 private:
  struct Seen {
    InputCounters counters{};
    Refusal cause{};
    bool told{};
  };
  static bool look_at(const char* name, const InputCounters& now, Seen& seen, const Logger& logger);

  Seen fixes_, odometry_, imu_;
  std::uint64_t unknown_covariance_{}, other_zone_{}, without_antenna_{};
  int waiting_looks_ = 0;
  bool is_troubled_ = false;
};

}  // namespace nacelle::navsat
