// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::diff_drive {

// VESC over UART or USB: framed payloads, big-endian.
// Source: vedderb/bldc, comm/packet.c and comm/commands.c, datatypes.h.
//
//   offset  bytes  field
//        0      1  0x02                    a frame with a length of one byte; others are not used here
//        1      1  length of the payload
//        2      n  payload: command, data
//      n+2      2  crc16                   XMODEM, over the payload
//      n+4      1  0x03
//
//   command                       data
//      5  set duty                i32, 1e-5
//      8  set speed               i32, electrical rpm
//     34  forward over CAN        u8 id, then a whole payload for the VESC with this id
//     50  get selected values     u32 mask; the answer repeats it, then the values of its bits in their order

/// Makes frames for two motors in its own fixed buffer. Each call overwrites what the one before returned.
/// Threads: belongs to one thread. Allocates: nothing.
class VescPrinter {
 public:
  static constexpr int kOnTheLine = -1;  ///< The VESC at the other end of the line itself, not one on its CAN bus.
  /// Of each motor the CAN id of its VESC, 0 to 253, or kOnTheLine.
  VescPrinter(int left_id, int right_id) : ids_{left_id, right_id} {}

  [[nodiscard]] ByteView speeds(std::int32_t left_erpm, std::int32_t right_erpm);
  /// Zero duty: the windings are shorted, which brakes without a speed controller.
  [[nodiscard]] ByteView zero_duties();
  /// Requests VescValues of both.
  [[nodiscard]] ByteView get_values();

  static constexpr std::size_t kLongestFrame = 12;

 private:
  void add(int id, std::uint8_t command, std::uint32_t data);

  const std::array<int, 2> ids_;
  std::array<std::uint8_t, 2 * kLongestFrame> bytes_{};
  std::size_t size_ = 0;
};

/// What the base reads of one VESC.
struct VescValues {
  std::uint8_t id = 0;          ///< Of the VESC on its CAN bus.
  std::int32_t erpm = 0;        ///< Mechanical rpm times pole pairs.
  std::int32_t tachometer = 0;  ///< Steps: six per electrical turn.
  double voltage_v = 0.0;
  std::uint8_t fault = 0;        ///< mc_fault_code
  std::uint64_t first_byte = 0;  ///< The number of its frame's first byte among all bytes that were fed.
  friend bool operator==(const VescValues&, const VescValues&) = default;
};

/// Reads a payload of command 50. Empty for other commands, and where one of the fields above is missing.
[[nodiscard]] std::optional<VescValues> decode_vesc_values(ByteView payload);

/// Returns the name of a fault, a text that lives forever; null for 0.
[[nodiscard]] const char* vesc_fault(std::uint8_t code, bool is_left);

/// Cuts bytes into frames; takes any chopping. A byte that begins no right frame is skipped, and the search goes on behind it.
///
/// Every byte is accounted for: bytes == value_bytes + other_bytes + lost_bytes + pending().
/// Threads: belongs to one thread. Allocates: nothing.
class VescDecoder {
 public:
  /// Longer frames (the answer of a whole configuration) are skipped as lost bytes: the base asks for none.
  static constexpr std::size_t kMaxPayload = 80;
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t frames = 0, value_bytes = 0;  ///< Of VescValues.
    std::uint64_t other_frames = 0, other_bytes = 0;
    std::uint64_t bad_checksums = 0;
    std::uint64_t lost_bytes = 0;
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls on_values(const VescValues&) for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_values) {
    for (const std::uint8_t byte : bytes) {
      ++stats_.bytes;
      buffer_[pending_++] = byte;
      while (const auto step = next_frame()) {
        if (step->values) on_values(*step->values);
      }
    }
  }
  void restart();

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  struct Step {
    std::optional<VescValues> values;
  };
  /// Takes one frame, or one byte that begins none, from the buffer; nothing if more bytes must come.
  [[nodiscard]] std::optional<Step> next_frame();
  void drop(std::size_t count);

  std::array<std::uint8_t, kMaxPayload + 5> buffer_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::diff_drive
