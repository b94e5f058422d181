// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

/// A classic CAN frame, as a value.
struct CanFrame {
  std::uint32_t id = 0;                ///< 11 bits, or 29 with is_extended.
  bool is_extended = false;            ///< The identifier has 29 bits.
  bool is_request = false;             ///< RTR: asks for a frame of this identifier, and has no data.
  std::uint8_t length = 0;             ///< Of the data; 0 to 8.
  std::array<std::uint8_t, 8> data{};  ///< Zeros behind `length`.
  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

// A frame as SocketCAN reads and writes it, in the machine's byte order.
// Source: struct can_frame of the kernel's <linux/can.h>.
//
//   offset  bytes  field
//        0      4  bits 0 to 28 identifier, 29 error of the controller, 30 request (RTR), 31 identifier of 29 bits
//        4      1  number of data bytes
//        5      3  padding
//        8      8  data
inline constexpr std::size_t kCanRecordBytes = 16;

using CanRecord = std::array<std::uint8_t, kCanRecordBytes>;
[[nodiscard]] CanRecord to_record(const CanFrame& frame);
/// Empty for a controller's error, and for what no controller sends: more than eight bytes, an identifier above its 11 bits.
/// Precondition: kCanRecordBytes bytes.
[[nodiscard]] std::optional<CanFrame> from_record(ByteView record);

/// Frames one behind the other in a fixed buffer. Threads: one. Allocates: nothing.
template <std::size_t kMost>
class CanFrameList {
 public:
  void clear() { size_ = 0; }
  /// Precondition: fewer than kMost are in it.
  CanFrameList& add(const CanFrame& frame) {
    const CanRecord record = to_record(frame);
    for (const std::uint8_t byte : record) bytes_[size_++] = byte;
    return *this;
  }
  [[nodiscard]] ByteView bytes() const { return {bytes_.data(), size_}; }

 private:
  std::array<std::uint8_t, kMost * kCanRecordBytes> bytes_{};
  std::size_t size_ = 0;
};

/// Cuts bytes into frames and these into reports, by `decode`, a function from CanFrame to an optional report. Takes any chopping.
///
/// Every byte is accounted for: bytes == report_bytes + other_bytes + lost_bytes + pending().
/// Threads: belongs to one thread. Allocates: nothing.
template <auto decode>
class CanDecoder {
 public:
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t report_bytes = 0;
    std::uint64_t other_bytes = 0;  ///< Right frames that are no reports.
    std::uint64_t lost_bytes = 0;   ///< Of records that are no frames.
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls on_report(const Report&, std::uint64_t first_byte): the frame's first byte is this one of all that were fed.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_report) {
    for (const std::uint8_t byte : bytes) {
      ++stats_.bytes;
      record_[pending_++] = byte;
      if (pending_ < kCanRecordBytes) continue;
      pending_ = 0;
      const auto frame = from_record(record_);
      if (!frame) {
        stats_.lost_bytes += kCanRecordBytes;
      } else if (const auto report = decode(*frame)) {
        stats_.report_bytes += kCanRecordBytes;
        on_report(*report, stats_.bytes - kCanRecordBytes);
      } else {
        stats_.other_bytes += kCanRecordBytes;
      }
    }
  }
  void restart() {
    stats_.lost_bytes += pending_;
    pending_ = 0;
  }

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  CanRecord record_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::diff_drive
