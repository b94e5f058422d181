// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// Failures of byte streams.
enum class StreamFault : std::uint8_t {
  HungUp,        ///< The other end is closed: a pulled cable, a closed pty. reopen() may restore it.
  ReadFailed,    ///< The kernel refused the read for another reason. reopen() may help.
  WriteFailed,   ///< The kernel refused the write for another reason.
  WouldBlock,    ///< The line took only a part of the bytes in time; the rest was not sent.
  NotFound,      ///< The path is not there (yet).
  NotPermitted,  ///< reopen(): the path is there, but this user may not open it.
  InUse,         ///< reopen(): another program has it open.
  NotUsable,     ///< reopen(): the path is there but is no terminal, or does not take the settings.
  NoAnswer,      ///< A bus: no device acknowledged the address.
  BusStuck,      ///< A bus: a line is held, no transfer ends.
  LineDown,      ///< A CAN interface: it is there, and set down. reopen() restores it once it is up.
  BusOff         ///< A CAN controller left its bus after too many errors. reopen() restores it once it is restarted.
};

/// "the line hung up (cable pulled?)"
[[nodiscard]] std::string_view explain(StreamFault fault);

/// A line that carries bytes both ways.
///
/// Threads: one thread reads, one other may write at the same time; interrupt() from any thread at any time.
/// Allocates: nothing after it was made.
class ByteStream {
 public:
  ByteStream() = default;
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;
  virtual ~ByteStream() = default;

  /// Waits until bytes, the deadline or an interrupt() come.
  ///
  /// An empty view means the deadline or an interrupt. The view is valid until the next call of read_until() or
  /// reopen().
  /// Errors: HungUp, ReadFailed. The stream stays unchanged; reopen() tries to restore it.
  [[nodiscard]] virtual Result<ByteView, StreamFault> read_until(MonotonicTime deadline) = 0;

  /// Sends all bytes, or says why not.
  /// Errors: HungUp, WriteFailed, WouldBlock.
  [[nodiscard]] virtual Result<void, StreamFault> write(ByteView bytes) = 0;

  /// Bytes that were written and have not left; 0 where the kernel does not say (a pty).
  [[nodiscard]] virtual std::size_t unsent() const noexcept { return 0; }
  /// Drops bytes that were written and have not left. A part of a frame may have left: the next write must not continue it.
  virtual void drop_unsent() noexcept {}

  /// Sets the modem line DTR, which some boards wire to a motor's driver. A line without modem lines (a pty) ignores it.
  /// Errors: HungUp, WriteFailed, NotFound.
  [[nodiscard]] virtual Result<void, StreamFault> set_data_terminal_ready(bool /*ready*/) { return {}; }

  /// Makes a waiting read_until() return an empty view at once; the next read waits again.
  virtual void interrupt() noexcept = 0;

  /// Opens the same line again after a fault. Only from the reading thread.
  /// Errors: NotFound (the stream may then be is_away()), NotPermitted, InUse, NotUsable (the stream is as before).
  [[nodiscard]] virtual Result<void, StreamFault> reopen() = 0;

  /// True while the device is absent, from the start or since reopen() did not find it; all else fails with NotFound meanwhile.
  [[nodiscard]] virtual bool is_away() const noexcept { return false; }

  /// The kernel's number of the line, the same for the stream's whole life (also across reopen()), or -1 without one.
  ///
  /// The runtime keeps it beside a prepared stop frame, so that a signal handler can write it (D7).
  [[nodiscard]] virtual int descriptor() const noexcept = 0;
};

}  // namespace nacelle::io
