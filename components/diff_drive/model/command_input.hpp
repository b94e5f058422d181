// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "diff_drive/model/command_inbox.hpp"

namespace nacelle::diff_drive {

/// When the base may move again after a stop (design D7).
enum class RearmRule : std::uint8_t {
  Neutral,  ///< The input has been zero or silent for one timeout, and then a command follows.
  Fresh,    ///< A command follows that came after the stop.
};

/// Reasons that hold the wheels still against any command.
enum class Hold : std::uint8_t {
  EmergencyStop = 1,  ///< Latched until it is released.
  LineLost = 2,       ///< The motor board cannot receive commands.
  Unguarded = 4,      ///< The emergency stop has no publisher, and one is required.
  Stopped = 8,        ///< Stopped from outside (MotionStops), until the next activation.
  BoardFault = 16,    ///< The motor board reports a fault of its own.
  Inactive = 32,      ///< The controller that follows commands is not active.
};

/// Decides what the wheels should do now: which of several inputs commands them, and whether any may.
///
/// An input is one topic. Among inputs whose newest command is within its timeout and that no lock blocks, the one with the
/// highest priority commands; among equals the first. Without commands the base stands still.
///
/// A stop (activation, an input's timeout, a lock, a hold) disarms the inputs that it stops. A disarmed one commands nothing
/// until it has been neutral: zero or silent for one timeout of its own (half a second where that is 0), refused commands
/// counting as neither. Its next command of motion arms it again. Commands from before the end of a hold count as old.
///
/// Source:  priorities, timeouts and locks are twist_mux's, except that priority 0 is an ordinary one here.
/// Threads: belongs to the control loop. Allocates: nothing after it was made.
class CommandInput {
 public:
  struct Source {
    Duration timeout = 500ms;  ///< Zero: commands stay in force.
    std::uint8_t priority = 0;
  };
  /// While locked (or silent for its timeout), inputs of a lower priority are ignored.
  struct Lock {
    Duration timeout{};  ///< Zero: a lock that says nothing is open.
    std::uint8_t priority = 0;
  };
  struct Settings {
    std::vector<Source> sources{Source{}};
    std::vector<Lock> locks;
    RearmRule rearm = RearmRule::Fresh;
  };
  enum class State : std::uint8_t {
    Waiting,   ///< Armed by an activation; no command has come since.
    Driving,   ///< A command is in force.
    TimedOut,  ///< The last command in force got too old.
    Locked,    ///< A lock blocks every input that would command.
    Held,      ///< See holds().
  };
  struct Stats {
    std::uint64_t taken = 0;  ///< Commands that came into force.
    std::uint64_t early = 0;  ///< Commands from before arm() or the end of a hold, dropped.
    std::uint64_t disarmed =
        0;  ///< Commands of motion that were not followed, since their input was not armed again yet.
    std::uint64_t timeouts = 0;   ///< Times that the base was stopped since a command in force got too old.
    std::uint64_t handovers = 0;  ///< Times that another input took over.
  };
  static constexpr std::size_t kNobody = SIZE_MAX;
  static constexpr Duration kNeutralWithoutTimeout = 500ms;

  explicit CommandInput(Settings settings);

  /// Starts anew: discards commands received before `now`. Holds stay.
  void arm(MonotonicTime now);
  void hold(Hold why);
  /// Ends a time in which no command was read: a stop. Earlier commands are discarded, and no input is known to be neutral.
  void forget(MonotonicTime now);
  /// Ends a hold; the inputs stay disarmed.
  void release(Hold why, MonotonicTime now);
  /// Takes only the holds from the inbox. Returns true if one of them is new. take() includes this.
  bool take_holds(const CommandInbox& inbox);
  /// Takes all commands from the inbox. Call it once per cycle, before wanted(). Returns whether a new command came into force,
  /// which `newest` then holds.
  bool take(CommandInbox& inbox, MonotonicTime now, DriveCommand& newest);
  /// Returns the commanded motion at this time.
  [[nodiscard]] BodyTwist wanted(MonotonicTime now);

  [[nodiscard]] State state() const { return state_; }
  /// Bits of Hold.
  [[nodiscard]] std::uint8_t holds() const { return holds_; }
  [[nodiscard]] bool is_held(Hold why) const { return (holds_ & static_cast<std::uint8_t>(why)) != 0; }
  /// The input that commands, or kNobody.
  [[nodiscard]] std::size_t selected() const { return selected_; }
  /// A command of motion came in the last timeout of its input and was not followed, since the input is not armed yet.
  [[nodiscard]] bool waits_for_neutral(MonotonicTime now) const;
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  struct Channel {
    DriveCommand command{};
    bool in_force = false;  // without being armed: a zero
    bool armed = false;
    bool heard = false;           // since arm()
    MonotonicTime restless_at{};  // the last command that was not neutral
    MonotonicTime disarmed_at{};  // the last one that was not followed for that
    bool was_disarmed = false;
  };

  void disarm_all();
  bool take(std::size_t index, const DriveCommand& command);
  [[nodiscard]] Duration neutral_period(std::size_t index) const;
  [[nodiscard]] int lock_priority(const CommandInbox& inbox, MonotonicTime now) const;

  const Settings settings_;
  std::vector<Channel> channels_;
  MonotonicTime armed_at_{};
  int lock_priority_ = -1;
  std::uint8_t holds_ = 0;
  State state_ = State::Waiting;
  std::size_t selected_ = kNobody;
  Stats stats_;
};

}  // namespace nacelle::diff_drive
