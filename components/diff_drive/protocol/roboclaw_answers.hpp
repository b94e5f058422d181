// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "diff_drive/protocol/roboclaw_packet.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

/// One answer of the board whose crc16 is right, or the 0xFF of a write.
struct RoboclawAnswer {
  RoboclawCommand command{};     ///< What it answers.
  std::int32_t value = 0;        ///< Encoders: M1. Speeds: signed counts/s. Battery: 0.1 V. Status: its bits.
  std::int32_t second = 0;       ///< Encoders: M2.
  bool is_old_layout = false;    ///< Status: of 16 bits.
  std::uint64_t first_byte = 0;  ///< The number of its first byte among all bytes that were fed.
  friend bool operator==(const RoboclawAnswer&, const RoboclawAnswer&) = default;
};

/// Finds the answers in the bytes of a RoboClaw. An answer does not name its question, so the port hands each question to expect().
///
/// Out of step (after a start, a wrong crc16, a missing answer) it discards all bytes until the first byte after a write is its 0xFF,
/// or until assume_step().
/// Every byte is accounted for: bytes == answer_bytes + lost_bytes + pending().
/// Threads: belongs to one thread. Allocates: nothing.
class RoboclawAnswers {
 public:
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t answers = 0, answer_bytes = 0;
    std::uint64_t lost_bytes = 0;     ///< Of answers whose crc16 is wrong, and all bytes while out of step.
    std::uint64_t bad_checksums = 0;  ///< Answers, of writes too, that were not what was awaited.
    std::uint64_t losses = 0;         ///< Times that it fell out of step, the first start not counted.
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  explicit RoboclawAnswers(std::uint8_t address) : address_(address) {}

  /// This command has been sent.
  void expect(RoboclawCommand command);
  /// Discards what has begun; a write that follows brings it into step.
  void fall_out_of_step();
  /// The line has been quiet for longer than any answer takes: nothing is on its way.
  void assume_step();
  /// True: questions may be asked.
  [[nodiscard]] bool is_in_step() const { return in_step_; }
  /// Answers that are awaited; out of step, those of writes since which no byte has come.
  [[nodiscard]] std::size_t awaited() const { return awaited_; }

  /// Calls on_answer(const RoboclawAnswer&) for each answer that ends in these bytes.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_answer) {
    for (const std::uint8_t byte : bytes) {
      if (const auto answer = take(byte)) on_answer(*answer);
    }
  }

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  [[nodiscard]] std::optional<RoboclawAnswer> take(std::uint8_t byte);
  [[nodiscard]] bool has_right_crc() const;
  [[nodiscard]] RoboclawAnswer finish();

  static constexpr std::size_t kMostAwaited = 16;
  const std::uint8_t address_;
  std::array<RoboclawCommand, kMostAwaited> queue_{};
  std::size_t awaited_ = 0;
  bool in_step_ = false;
  std::array<std::uint8_t, 10> buffer_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::diff_drive
