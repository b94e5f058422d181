// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "control/client.hpp"
#include "nacelle/base/time.hpp"
#include "process/stop_signal.hpp"
#include "teleop/model/teleop_keys.hpp"

namespace nacelle::teleop {

struct TeleopSettings {
  std::string container;  ///< Full name of the container's node.
  std::string topic = "/cmd_vel";
  bool stamped = true;  ///< TwistStamped; else Twist.
  std::string frame = "base_link";
  TeleopOptions keys;
};

/// Drives from the keys of stdin until Ctrl-C, a signal, or the end of the terminal; sends a zero whatever the end is. `asking`, a
/// second connection, asks which emergency stops are set; while one is, the line shows that in the place of a speed.
/// Returns the process's exit code; the terminal is as it was before.
[[nodiscard]] int run_teleop(control::Client& client, control::Client& asking, const TeleopSettings& settings,
                             const process::StopSignal& stop, const Clock& clock);

}  // namespace nacelle::teleop
