// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "diff_drive/model/drive_kinematics.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// A command of an operator or a planner, as it reaches the control loop.
struct DriveCommand {
  BodyTwist wanted;
  MonotonicTime received_at{};   ///< When the callback saw it: ages count from here, the wall clock may step.
  MonotonicTime published_at{};  ///< When the sender published it, for the latency figure.
  bool first_of_sender = false;  ///< Nothing came from this sender before: it cannot be the rest of an older drive.
};

/// Why a command was refused; the one before it stays in force.
enum class CommandFault : std::uint8_t {
  NotFinite,  ///< A part of the message is NaN or infinite.
  Absurd,     ///< Faster than kMaxSaneLinear or kMaxSaneAngular: a unit mistake or garbage.
  Stale,      ///< Its header stamp is older than the input's timeout: it waited somewhere.
  Inactive,   ///< The controller that follows commands is not active.
};
inline constexpr std::size_t kCommandFaults = 4;

/// A command above these limits comes from a broken sender. The actual limits are parameters.
inline constexpr double kMaxSaneLinear_mps = 50.0;
inline constexpr double kMaxSaneAngular_rps = 100.0;

/// The six numbers of a geometry_msgs/Twist.
struct RawTwist {
  double linear_x = 0.0, linear_y = 0.0, linear_z = 0.0;
  double angular_x = 0.0, angular_y = 0.0, angular_z = 0.0;
};

/// The part that a differential drive can follow. Errors: CommandFault::NotFinite (any of the six), Absurd.
[[nodiscard]] Result<BodyTwist, CommandFault> accepted(const RawTwist& twist);

}  // namespace nacelle::diff_drive
