// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>
#include <string_view>

#include "diff_drive/model/command_input.hpp"
#include "diff_drive/model/twist_limiter.hpp"
#include "diff_drive/port/base_port.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/io/backoff.hpp"

namespace nacelle::diff_drive {

/// Callbacks of the control loop. Threads: the one that runs the loop. Must not block or throw.
class DriveObserver {
 public:
  DriveObserver() = default;
  DriveObserver(const DriveObserver&) = delete;
  DriveObserver& operator=(const DriveObserver&) = delete;
  virtual ~DriveObserver() = default;

  virtual void on_wheel_state(const WheelState& state) = 0;
  /// A cycle ended; `commanded` is the command to the wheels.
  virtual void on_cycle(const BodyTwist& commanded, MonotonicTime now) = 0;
  /// The first frame that carries a new command has been written: so long after the command was published.
  virtual void on_command_written(Duration since_published) = 0;
  /// Settings::waits_for_board: the board is lost, silent, or accepts nothing, with the reason; later, that it is back.
  virtual void on_board_lost(std::string_view) {}
  virtual void on_board_back(MonotonicTime) {}
};

/// Why the loop cannot continue. A stop was sent to the wheels, if possible.
struct DriveFault {
  enum class Kind : std::uint8_t {
    SerialLost,    ///< The line is lost, and was not back within Settings::reopen_limit.
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
/// A command is followed as fast as the limits allow, also a command of zero. A stop (no more commands, a hold) ignores
/// the limits: the wheels get zero in that cycle. An emergency stop does not wait for the cycle, if the loop is
/// interrupted for it. With Settings::waits_for_board a board that is lost (no line, no feedback, no byte taken) is
/// sent zero and opened again without limit; earlier commands are not resumed when it is back (CommandInput). Without
/// it, a lost line is reopened for as long as Settings::reopen_limit, and silence is a fault. If the loop itself did
/// not run (a stopped process, a starved machine) for the maximum age of a command, or for the time of the board's own
/// watchdog, it starts anew: the wheels were stopped meanwhile, or should have been.
///
/// Cycles end at absolute instants of the monotonic clock; a late one does not move those that follow. Between them the
/// loop waits on the feedback itself, so every line is read, and stamped, when it arrives, by this one thread.
/// Threads:   run() in one thread; stop() from any. The rest before or after.
/// Allocates: nothing while the board is there.
class DriveLoop {
 public:
  struct Settings {
    DriveGeometry geometry;
    TwistLimits limits;  ///< resolved()
    Duration period = 20ms;
    CommandInput::Settings input;
    bool waits_for_board = false;  ///< A lost board is waited for; the two limits below count only without.
    Duration silence_report =
        500ms;  ///< With waits_for_board: after so long without feedback, or a byte taken, it is lost.
    Duration silence_limit = 1s;  ///< Zero: the board may be silent, and the line stuck, forever.
    Duration reopen_limit{};      ///< Zero: a lost line is a fault at once.
    Duration motor_watchdog{};    ///< After so long without a command the board stops by itself; zero: it does not.
  };
  /// Returns the loop's state, for observers. Threads: any.
  struct alignas(4) Look {  // one word, so that every compiler makes its atomic without a lock
    CommandInput::State state = CommandInput::State::Waiting;
    std::uint8_t holds = 0;          ///< Bits of Hold.
    bool waits_for_neutral = false;  ///< Motion is commanded, but not followed until the input was neutral.
    std::uint8_t selected = kNobody;
    static constexpr std::uint8_t kNobody = 255;
    friend bool operator==(const Look&, const Look&) = default;
  };
  struct Stats {
    std::uint64_t cycles = 0;
    std::uint64_t skipped = 0;       ///< Periods that passed while a cycle was late.
    std::uint64_t unwritten = 0;     ///< Cycles whose command did not get through.
    std::uint64_t lost = 0;          ///< Times that the line was lost.
    std::uint64_t reopened = 0;      ///< Times that it came back: lost == reopened, or one more.
    std::uint64_t board_faults = 0;  ///< Times that the board began to report a fault.
    CommandInput::Stats commands;
  };

  /// Everything outlives the loop. Commands come through `inbox`, from one other thread.
  DriveLoop(const Settings& settings, BasePort& port, const Clock& clock, CommandInbox& inbox, DriveObserver& observer);

  /// Commands received before this instant count no more; cycles are counted from it. Call before run().
  void arm(MonotonicTime now);
  /// After arm(): the board did not answer; it is held and tried as a lost one. Only with waits_for_board.
  void begin_without_board();
  /// Runs until stop() or a fault. Sends no stop itself when it ends by stop().
  [[nodiscard]] Result<void, DriveFault> run();
  /// One cycle, for run() and for tests.
  [[nodiscard]] Result<void, DriveFault> cycle();
  void stop() noexcept;
  /// Call when an emergency stop is in the inbox: the wheels are stopped at once, not in the next cycle. Threads: any.
  void interrupt() noexcept { port_.interrupt(); }

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] CommandInput::State command_state() const { return input_.state(); }
  [[nodiscard]] Look look() const { return look_.load(std::memory_order_relaxed); }
  /// CommandInbox::orders as of the last whole cycle: what was published in it, or commanded, already followed them. Threads: any.
  [[nodiscard]] std::uint32_t orders_followed() const { return orders_followed_.load(std::memory_order_acquire); }
  /// The fault that the board reports, or null. The wheels are held while there is one. Threads: any.
  [[nodiscard]] const char* board_fault() const { return board_fault_.load(std::memory_order_relaxed); }

 private:
  class Ears final : public WheelStateSink {
   public:
    explicit Ears(DriveLoop& loop) : loop_(loop) {}
    void on_wheel_state(const WheelState& state) override;
    void on_board_fault(const char* fault) override;

   private:
    DriveLoop& loop_;
  };

  [[nodiscard]] Result<void, DriveFault> listen();
  /// Stops that do not wait for the end of a cycle.
  void apply_stops();
  [[nodiscard]] std::uint64_t stops_from_outside() const;
  [[nodiscard]] double elapsed_periods(MonotonicTime now);
  [[nodiscard]] Result<void, DriveFault> drive(const BodyTwist& twist);
  /// The line is lost: a fault if it is not to be reopened, else the start of the wait for it.
  [[nodiscard]] Result<void, DriveFault> lose_line(BaseFault why);
  /// Tries to open it again when it is time to.
  [[nodiscard]] Result<void, DriveFault> bring_line_back(MonotonicTime now);
  /// The line is there, the board is not: silent, or it takes nothing.
  void lose_board(std::string_view why, MonotonicTime now);
  /// Wakes a silent board when it is time to, and notices that it speaks.
  void bring_board_back(MonotonicTime now);
  /// Silence, and a line that takes nothing for too long.
  [[nodiscard]] Result<void, DriveFault> watch_board(MonotonicTime now);
  [[nodiscard]] BodyTwist next_twist(MonotonicTime now, double step_s);

  const Settings settings_;
  const Duration absence_limit_;
  BasePort& port_;
  const Clock& clock_;
  CommandInbox& inbox_;
  DriveObserver& observer_;
  Ears ears_{*this};
  CommandInput input_;
  TwistLimiter limiter_;
  std::optional<MonotonicTime> lost_at_;    // the line is away since
  std::optional<MonotonicTime> silent_at_;  // the line is there, the board is lost since
  bool silence_told_ = false;               // why it is silent was reported
  io::Backoff backoff_;
  MonotonicTime next_attempt_{};
  BaseFault line_fault_ = BaseFault::LineLost;
  std::optional<DriveCommand> unwritten_;  // in force, but no frame has carried it yet
  MonotonicTime due_{};
  MonotonicTime cycled_at_{};
  std::uint64_t stops_at_arm_ = 0;
  bool stops_at_once_ = false;  // a hold was made while listening
  MonotonicTime heard_at_{};
  MonotonicTime written_at_{};
  std::atomic<bool> stop_{false};
  std::atomic<Look> look_{Look{}};
  std::atomic<const char*> board_fault_{nullptr};
  std::atomic<std::uint32_t> orders_followed_{0};
  Stats stats_;
};

}  // namespace nacelle::diff_drive
