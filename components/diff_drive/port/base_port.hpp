// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "diff_drive/model/drive_kinematics.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// What the motor board says about the wheels at one instant.
struct WheelState {
  double left_rad = 0.0;  ///< Angle turned since some fixed time; continues across restarts of the board.
  double right_rad = 0.0;
  WheelRates rates;  ///< As the board measured them.
  std::optional<double> voltage_v;
  MonotonicTime captured_at{};
};

/// Why the base could not be read or commanded.
enum class BaseFault : std::uint8_t {
  LineLost,      ///< The other end is gone (pulled cable); only reopening may help.
  LineStuck,     ///< The line took no bytes, or only a part, in time. The wheels keep their motion. Try again.
  LineRefused,   ///< The kernel refused for another reason.
  LineDown,      ///< A CAN interface that is set down; reopening helps once it is up.
  BusOff,        ///< The CAN controller left its bus after too many errors; reopening helps once it is restarted.
  OutputLost,    ///< The kernel takes no values for the motors' PWM channels or GPIO lines: their chip is gone.
  EncodersLost,  ///< The kernel hands out no values of the wheels' encoders: their counter or GPIO chip is gone.
  NotSendable,   ///< The rates are not finite or above max_wheel_rate(): a bug of the caller. Nothing was sent.
};
[[nodiscard]] std::string_view explain(BaseFault fault);

/// Takes what read_until() finds. Threads: called from the reading thread.
class WheelStateSink {
 public:
  WheelStateSink() = default;
  WheelStateSink(const WheelStateSink&) = delete;
  WheelStateSink& operator=(const WheelStateSink&) = delete;
  virtual ~WheelStateSink() = default;
  virtual void on_wheel_state(const WheelState& state) = 0;
  /// The board reports a fault of its own (a text that lives forever), or none any more (null). May repeat itself.
  virtual void on_board_fault(const char* /*fault*/) {}
};

/// A base on two driven wheels, local or behind a line.
///
/// Threads:   one at a time; interrupt() from any.
/// Allocates: nothing after it was made.
class BasePort {
 public:
  struct Stats {
    std::uint64_t commands = 0;                  ///< Speed commands that were sent whole, stops included.
    std::uint64_t stuck = 0;                     ///< BaseFault::LineStuck.
    std::uint64_t states = 0;                    ///< Wheel states handed out.
    std::uint64_t board_restarts = 0;            ///< The board's counters restarted; the positions continue.
    std::uint64_t bytes_in = 0, bytes_lost = 0;  ///< Received, and those of them that were no usable line.
    std::uint64_t edges = 0, edges_lost = 0;     ///< Of encoders, where the port counts them; missing ones are extra.
  };

  BasePort() = default;
  BasePort(const BasePort&) = delete;
  BasePort& operator=(const BasePort&) = delete;
  virtual ~BasePort() = default;

  /// Stops the wheels, requests the feedback that the driver needs, and discards earlier feedback.
  [[nodiscard]] virtual Result<void, BaseFault> start() = 0;
  /// Hands wheel states to the sink as they come; returns after the first ones, at the deadline, or on interrupt().
  /// Errors: LineLost, LineRefused, LineDown, BusOff.
  [[nodiscard]] virtual Result<void, BaseFault> read_until(MonotonicTime deadline, WheelStateSink& sink) = 0;
  /// Has returned when the kernel has the whole command. Precondition: finite, no wheel above max_wheel_rate().
  /// Errors: all.
  [[nodiscard]] virtual Result<void, BaseFault> write(const WheelRates& rates) = 0;
  /// Commands zero, with the stop frame where there is one.
  [[nodiscard]] virtual Result<void, BaseFault> stop() = 0;
  /// Opens a lost line again and starts the board behind it; the descriptor's number stays.
  /// Errors: LineLost, LineDown, BusOff while it is so, LineRefused; the port is then as before.
  [[nodiscard]] virtual Result<void, BaseFault> reopen() { return start(); }
  /// Waits without listening, for a line that is lost; returns at the deadline or on interrupt().
  virtual void rest_until(MonotonicTime deadline) = 0;
  /// Makes a waiting read_until() or rest_until() return at once; the next one waits again.
  virtual void interrupt() noexcept = 0;

  /// Returns the highest wheel speed that a command may request, in rad/s; infinity if the base has no limit of its own.
  [[nodiscard]] virtual double max_wheel_rate() const = 0;
  /// Bytes that stop the wheels when they are written to descriptor() (design D7); empty without a line.
  [[nodiscard]] virtual ByteView stop_frame() const = 0;
  [[nodiscard]] virtual int descriptor() const noexcept = 0;  ///< -1 without a line.
  /// Where stop_frame() must be written, too.
  [[nodiscard]] virtual std::span<const int> further_descriptors() const noexcept { return {}; }
  [[nodiscard]] virtual Stats stats() const = 0;
  /// Says why no wheel state has come since the line was opened, as far as the bytes of the line tell: nothing came, or what came is another
  /// device's. Empty if states came, or nothing is known. `waited`: how long it was waited for one. Allocates.
  [[nodiscard]] virtual std::string why_no_state(Duration /*waited*/) const { return {}; }
};

}  // namespace nacelle::diff_drive
