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

/// Drives from the keys of stdin until Ctrl-C, another signal, or the end of the terminal. Sends zero commands at the
/// end in any case. `asking` is a second connection that queries which emergency stops are set; while one is set, the
/// line shows that instead of a speed. Restores the terminal. Returns the process's exit code.
[[nodiscard]] int run_teleop(control::Client& client, control::Client& asking, const TeleopSettings& settings,
                             const process::StopSignal& stop, const Clock& clock);

}  // namespace nacelle::teleop
