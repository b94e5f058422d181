// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/io/byte_stream.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::io {

/// A classic CAN frame as SocketCAN reads and writes it, struct can_frame of <linux/can.h>, in the machine's byte order:
///
///   offset  bytes  field
///        0      4  identifier of 11 or 29 bits, with the flags below
///        4      1  number of data bytes, 0 to 8
///        5      3  padding
///        8      8  data
inline constexpr std::size_t kCanFrameBytes = 16;
inline constexpr std::uint32_t kCanExtended = 0x80000000;  ///< The identifier has 29 bits.
inline constexpr std::uint32_t kCanRemote = 0x40000000;    ///< A request (RTR): no data.
inline constexpr std::uint32_t kCanError = 0x20000000;     ///< No frame of the bus: the controller reports an error.

/// A frame passes if its identifier, flags included, equals `id` in the bits of `mask`.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  friend bool operator==(const CanFilter&, const CanFilter&) = default;
};

struct CanSettings {
  std::string interface = "can0";
  std::vector<CanFilter> filters;  ///< Frames that pass one of them are read; none: all frames. In the kernel.
  Duration write_timeout = 10ms;   ///< A bus that takes no frame for this long is WouldBlock.
};

/// Returns the CAN interfaces that there are, up or down.
[[nodiscard]] std::vector<std::string> can_interfaces();

/// A CAN interface of the kernel (SocketCAN), as a stream of whole frames: every chunk that is read, and all bytes that are
/// written, are so many times kCanFrameBytes. Each frame is a write of its own.
///
/// Several programs may use one interface. Error frames of the controller are not handed out: they are counted, and the one
/// that tells that the controller went off the bus is StreamFault::BusOff, once. An interface that is set down is LineDown.
/// The bit rate is the interface's, and set outside of this program: ip link set can0 up type can bitrate 500000.
class CanPort final : public ByteStream {
 public:
  struct Stats {
    std::uint64_t frames_in = 0;
    std::uint64_t frames_out = 0;
    std::uint64_t error_frames = 0;  ///< Reports of the controller, those of bus-off included.
    std::uint64_t bus_offs = 0;
    std::uint64_t odd_reads = 0;  ///< Reads of another length than a frame's, which were dropped.
  };

  /// Opens the interface; waits up to `patience` for it to be there and up.
  ///
  /// Errors: a Problem that names the interface and the way out (no such one, not CAN, down, off the bus, no permission, a
  /// kernel without CAN).
  [[nodiscard]] static Result<std::unique_ptr<CanPort>, Problem> open(const CanSettings& settings, const Clock& clock,
                                                                      Duration patience = {});
  /// As open(), but an interface that is absent, down or off the bus is no error: is_away() until reopen() succeeds. Does not wait.
  [[nodiscard]] static Result<std::unique_ptr<CanPort>, Problem> open_or_await(const CanSettings& settings,
                                                                               const Clock& clock);
  /// Takes a bound socket, or in tests an end of a SOCK_SEQPACKET pair, whose messages are frames as well.
  [[nodiscard]] static std::unique_ptr<CanPort> adopt(Descriptor socket, const CanSettings& settings,
                                                      const Clock& clock);

  /// Errors also: LineDown, BusOff.
  [[nodiscard]] Result<ByteView, StreamFault> read_until(MonotonicTime deadline) override;
  /// If a frame fails, those before it have been sent. Precondition: whole frames.
  /// Errors also: LineDown. WouldBlock also if the interface's queue is full (ENOBUFS).
  [[nodiscard]] Result<void, StreamFault> write(ByteView frames) override;
  /// Kernel memory of frames that wait for the controller; those that it has taken are not counted.
  [[nodiscard]] std::size_t unsent() const noexcept override;
  void interrupt() noexcept override { bell_.ring(); }
  /// Errors also: LineDown, BusOff.
  [[nodiscard]] Result<void, StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override { return away_.load(std::memory_order_acquire); }
  [[nodiscard]] int descriptor() const noexcept override { return socket_.number(); }

  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  CanPort(CanSettings settings, const Clock& clock, Descriptor socket);

  [[nodiscard]] Result<void, StreamFault> write_frame(ByteView frame, MonotonicTime deadline);
  /// Reads what is there; returns the bytes of data frames. A fault behind them is left in `pending_`.
  [[nodiscard]] std::size_t read_frames();

  CanSettings settings_;
  const Clock& clock_;
  Descriptor socket_;  // its number is the port's for good
  std::atomic<bool> away_{false};
  StreamFault away_as_ = StreamFault::NotFound;
  std::optional<StreamFault> pending_;  // for the next read
  Bell bell_;
  Stats stats_;
  std::array<std::uint8_t, 64 * kCanFrameBytes> buffer_{};
};

}  // namespace nacelle::io
