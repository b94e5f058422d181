// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/io/byte_stream.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::io {

/// How a serial line is opened: 8 data bits, no parity, one stop bit, no flow control, nothing translated.
struct SerialSettings {
  std::string path;                ///< "/dev/serial/by-id/..." survives another order of plugging in.
  unsigned baud = 115200;          ///< One of the standard rates, 1200 to 4000000.
  Duration write_timeout = 100ms;  ///< A line that takes no byte for this long is WouldBlock.
  friend bool operator==(const SerialSettings&, const SerialSettings&) = default;
};

/// Time one byte takes on the line: start bit, 8 data bits, stop bit.
[[nodiscard]] constexpr Duration byte_time(unsigned baud) {
  return Duration{10'000'000'000LL / (baud == 0 ? 1 : baud)};
}

/// True for a baud rate that devices have: those that the kernel has a name for, and 128000, 153600, 256000 and 512000.
[[nodiscard]] bool is_standard_baud(unsigned baud);

/// A serial line of the kernel.
///
/// Opened for one program only: with flock(), and with TIOCEXCL on real lines. A pty does not get TIOCEXCL, because it
/// would keep the mark after this process was killed for as long as its other end lives.
/// HUPCL is off: a board that resets on a falling DTR is not reset by a restart of the driver.
class SerialPort final : public ByteStream {
 public:
  /// Opens the line; waits up to `patience` for the path to appear.
  ///
  /// Errors: a Problem that names the path and the way out (not there, no right, in use, not a terminal, odd baud
  /// rate).
  [[nodiscard]] static Result<std::unique_ptr<SerialPort>, Problem> open(const SerialSettings& settings,
                                                                         const Clock& clock, Duration patience = {});

  /// As open(), but an absent device is no error: is_away() until reopen() finds it. Does not wait.
  [[nodiscard]] static Result<std::unique_ptr<SerialPort>, Problem> open_or_await(const SerialSettings& settings,
                                                                                  const Clock& clock);

  [[nodiscard]] Result<ByteView, StreamFault> read_until(MonotonicTime deadline) override;
  [[nodiscard]] Result<void, StreamFault> write(ByteView bytes) override;
  [[nodiscard]] std::size_t unsent() const noexcept override;
  /// Of a pty, up to 4095 bytes are the other end's already, and stay.
  void drop_unsent() noexcept override;
  [[nodiscard]] Result<void, StreamFault> set_data_terminal_ready(bool ready) override;
  void interrupt() noexcept override { bell_.ring(); }
  /// Takes the path again; the new line gets the old one's number, so that descriptor() never changes. If the path is gone, lets go of the
  /// old line: is_away().
  [[nodiscard]] Result<void, StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override { return away_.load(std::memory_order_acquire); }
  [[nodiscard]] int descriptor() const noexcept override { return line_.number(); }

  [[nodiscard]] const SerialSettings& settings() const { return settings_; }

 private:
  SerialPort(SerialSettings settings, const Clock& clock, Descriptor line);

  SerialSettings settings_;
  const Clock& clock_;
  Descriptor line_;  // of the null device while it is away: the number is the line's for good
  std::atomic<bool> away_{false};
  Bell bell_;
  std::array<std::uint8_t, 4096> buffer_{};  // the kernel's own line buffer has this size
};

}  // namespace nacelle::io
