// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include "ekf/component/ekf_options.hpp"
#include "nacelle/base/log.hpp"

namespace nacelle::ekf {

/// Logs slip, wheels that stand on a robot that moves, an IMU that is not believed, and the gyro's bias once it is known. Each of
/// them at once, and again after ten seconds at the earliest.
/// Threads: one. Allocates: only to log.
class AssistWatch {
 public:
  /// Looks at what happened since the last look; call about once a second.
  void look(const Filter& filter, const EkfOptions& options, const Logger& logger);

 private:
  struct Told {
    std::uint64_t count{};
    int looks{};  // until it may be told again
  };
  [[nodiscard]] static bool is_due(Told& told, std::uint64_t count);
  Told slip_, contradiction_;
  bool distrusts_{false}, bias_known_{false};
};

/// One status for each assist that is on. Allocates: yes.
void write_assist_diagnostics(const Filter& filter, const EkfOptions& options, const std::string& node,
                              diagnostic_msgs::msg::DiagnosticArray& out);

}  // namespace nacelle::ekf
