// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "diff_drive/model/drive_kinematics.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// What a person or a planner asked for, as it reaches the control loop.
struct DriveCommand {
  BodyTwist wanted;
  MonotonicTime received_at{};   ///< When the callback saw it: ages count from here, the wall clock may step.
  MonotonicTime published_at{};  ///< When the sender published it, for the latency figure.
};

/// Why a command was refused; the one before it stays in force.
enum class CommandFault : std::uint8_t {
  NotFinite,  ///< A part of the message is NaN or infinite.
  Absurd,     ///< Faster than kMaxSaneLinear or kMaxSaneAngular: a unit mistake or garbage.
  Stale,      ///< Its header stamp is older than the command timeout: it waited somewhere.
};

/// A base on wheels that is told to go faster has a broken sender. Limits proper are parameters.
inline constexpr double kMaxSaneLinear_mps = 50.0;
inline constexpr double kMaxSaneAngular_rps = 100.0;

/// The six numbers of a geometry_msgs/Twist.
struct RawTwist {
  double linear_x = 0.0, linear_y = 0.0, linear_z = 0.0;
  double angular_x = 0.0, angular_y = 0.0, angular_z = 0.0;
};

/// The part that a differential drive can follow. Errors: CommandFault::NotFinite (any of the six), Absurd.
[[nodiscard]] Result<BodyTwist, CommandFault> accepted(const RawTwist& twist);

/// Decides what the wheels should do now: the newest command, or zero when there is none or it is too old.
///
/// After arm() and after a timeout the base stays stopped until a new command comes.
/// Threads: belongs to the control loop. Allocates: nothing.
class CommandWatch {
 public:
  enum class State : std::uint8_t {
    Waiting,   ///< Armed; no command has come since.
    Driving,   ///< A command is in force.
    TimedOut,  ///< The last command is older than the timeout.
  };
  struct Stats {
    std::uint64_t taken = 0;     ///< Commands that came into force.
    std::uint64_t early = 0;     ///< Commands from before arm(), dropped.
    std::uint64_t timeouts = 0;  ///< Times that a command in force got too old.
  };

  /// A timeout of zero never expires.
  explicit CommandWatch(Duration timeout) : timeout_(timeout) {}

  /// Starts anew: what was received before `now` counts no more.
  void arm(MonotonicTime now);
  /// Takes a command that the loop has not seen yet. Returns whether it is in force.
  bool take(const DriveCommand& command);
  /// What is wanted at this time; may change the state to TimedOut.
  [[nodiscard]] BodyTwist wanted(MonotonicTime now);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  Duration timeout_;
  MonotonicTime armed_at_{};
  DriveCommand command_{};
  State state_ = State::Waiting;
  Stats stats_;
};

}  // namespace nacelle::diff_drive
