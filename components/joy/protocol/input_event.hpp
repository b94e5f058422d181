// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::joy {

namespace input_layout {
// One event of /dev/input/eventN as a 64-bit kernel writes it: 24 bytes, little-endian on every machine that Nacelle runs on.
// Source: linux/input.h (struct input_event); Documentation/input/event-codes.rst of the kernel.
//
//   offset  bytes  field
//        0      8  seconds, int64
//        8      8  microseconds, int64
//       16      2  type: 0 SYN, 1 KEY, 3 ABS, 4 MSC, 21 FF
//       18      2  code
//       20      4  value, int32: of a key 0 up, 1 down, 2 repeated
//
// A group of events that belong to one moment ends with SYN_REPORT. SYN_DROPPED: the reader was too slow and events are lost; everything up
// to the next SYN_REPORT is to be dropped, and the state to be read anew.
inline constexpr std::size_t kSeconds = 0, kMicroseconds = 8, kType = 16, kCode = 18, kValue = 20, kEventBytes = 24;
inline constexpr std::uint16_t kSyn = 0, kKey = 1, kAbs = 3;
inline constexpr std::uint16_t kSynReport = 0, kSynDropped = 3;
}  // namespace input_layout

struct InputEvent {
  MonotonicTime at{};  ///< The kernel's; of CLOCK_MONOTONIC, if the device was asked for it (EVIOCSCLOCKID).
  std::uint16_t type{}, code{};
  std::int32_t value{};
  [[nodiscard]] bool is_syn(std::uint16_t kind) const { return type == input_layout::kSyn && code == kind; }
  friend bool operator==(const InputEvent&, const InputEvent&) = default;
};

/// Reads one event. Precondition: there are kEventBytes.
[[nodiscard]] InputEvent read_input_event(const std::uint8_t* at);

/// Cuts bytes into events, however they are chopped. The kernel hands over whole events.
///
/// Threads: one. Allocates: nothing.
class InputEventDecoder {
 public:
  /// Every byte that was fed is in one place: bytes == 24 * events + dropped_bytes + pending().
  struct Stats {
    std::uint64_t bytes{};          ///< Fed so far.
    std::uint64_t events{};         ///< Handed to the sink.
    std::uint64_t dropped_bytes{};  ///< Of half an event at a restart().
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Takes the next event off the front of `bytes`; none if its end has not come, and then no byte is left.
  [[nodiscard]] std::optional<InputEvent> next(ByteView& bytes) {
    const std::size_t taken = std::min(bytes.size(), input_layout::kEventBytes - pending_);
    std::copy_n(bytes.begin(), taken, window_.begin() + static_cast<std::ptrdiff_t>(pending_));
    stats_.bytes += taken;
    pending_ += taken;
    bytes = bytes.subspan(taken);
    if (pending_ < input_layout::kEventBytes) return std::nullopt;
    pending_ = 0;
    ++stats_.events;
    return read_input_event(window_.data());
  }

  /// Forgets half an event: the device was opened again.
  void restart() {
    stats_.dropped_bytes += pending_;
    pending_ = 0;
  }
  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  std::array<std::uint8_t, input_layout::kEventBytes> window_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::joy
