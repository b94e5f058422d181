// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>

#include "diff_drive/model/drive_command.hpp"
#include "diff_drive/model/latest_value.hpp"
#include "diff_drive/model/twist_limiter.hpp"
#include "diff_drive/port/base_port.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// What the control loop tells. Threads: every call comes from the thread that runs the loop. Must not block or throw.
class DriveObserver {
 public:
  DriveObserver() = default;
  DriveObserver(const DriveObserver&) = delete;
  DriveObserver& operator=(const DriveObserver&) = delete;
  virtual ~DriveObserver() = default;

  virtual void on_wheel_state(const WheelState& state) = 0;
  /// A cycle ended; `commanded` is what the wheels were told.
  virtual void on_cycle(const BodyTwist& commanded, MonotonicTime now) = 0;
  /// The first frame that carries a new command has been written: so long after the command was published.
  virtual void on_command_written(Duration since_published) = 0;
};

/// Why the loop cannot go on. The wheels were told to stop, if anything could be told.
struct DriveFault {
  enum class Kind : std::uint8_t {
    SerialLost,    ///< The line is gone or refuses.
    SerialStuck,   ///< No command got through for longer than Settings::silence_limit.
    FeedbackLost,  ///< The board said nothing for longer than Settings::silence_limit.
  };
  Kind kind;
  BaseFault base = BaseFault::LineLost;  ///< What the port said last; meaningless for FeedbackLost.
};
/// "SERIAL_LOST", "SERIAL_STUCK", "FEEDBACK_LOST"
[[nodiscard]] const char* code_of(DriveFault::Kind kind);

/// The control loop of the base: read feedback, take the newest command, limit it, write wheel rates; at a fixed rate.
///
/// Cycles end at absolute instants of the monotonic clock; a late one does not move those that follow. Between them the
/// loop waits on the feedback itself, so every line is read, and stamped, when it arrives, by this one thread.
/// Threads:   run() in one thread; stop() from any. The rest before or after.
/// Allocates: nothing.
class DriveLoop {
 public:
  struct Settings {
    DriveGeometry geometry;
    TwistLimits limits;  ///< resolved()
    Duration period = 20ms;
    Duration command_timeout = 500ms;  ///< Zero: commands stay in force.
    Duration silence_limit = 1s;       ///< Zero: the board may be silent, and the line stuck, for ever.
  };
  struct Stats {
    std::uint64_t cycles = 0;
    std::uint64_t skipped = 0;    ///< Periods that passed while a cycle was late.
    std::uint64_t unwritten = 0;  ///< Cycles whose command did not get through.
    CommandWatch::Stats commands;
  };

  /// Everything outlives the loop. Commands come through `commands`, from one other thread.
  DriveLoop(const Settings& settings, BasePort& port, const Clock& clock, LatestValue<DriveCommand>& commands,
            DriveObserver& observer);

  /// Commands received before this instant count no more; cycles are counted from it. Call before run().
  void arm(MonotonicTime now);
  /// Runs until stop() or a fault. Does not command a stop itself when it was told to end.
  [[nodiscard]] Result<void, DriveFault> run();
  /// One cycle, for run() and for tests.
  [[nodiscard]] Result<void, DriveFault> cycle();
  void stop() noexcept;

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] CommandWatch::State command_state() const { return watch_.state(); }

 private:
  class Ears final : public WheelStateSink {
   public:
    explicit Ears(DriveLoop& loop) : loop_(loop) {}
    void on_wheel_state(const WheelState& state) override;

   private:
    DriveLoop& loop_;
  };

  [[nodiscard]] Result<void, DriveFault> listen();
  [[nodiscard]] double elapsed_periods(MonotonicTime now);
  [[nodiscard]] Result<void, DriveFault> drive(const BodyTwist& twist);

  const Settings settings_;
  BasePort& port_;
  const Clock& clock_;
  LatestValue<DriveCommand>& commands_;
  DriveObserver& observer_;
  Ears ears_{*this};
  CommandWatch watch_;
  TwistLimiter limiter_;
  std::optional<DriveCommand> unwritten_;  // in force, but no frame has carried it yet
  MonotonicTime due_{};
  MonotonicTime heard_at_{};
  MonotonicTime written_at_{};
  std::atomic<bool> stop_{false};
  Stats stats_;
};

}  // namespace nacelle::diff_drive
