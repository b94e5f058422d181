// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/protocol/motor_frame.hpp"
#include "diff_drive/protocol/number_lines.hpp"

namespace nacelle::diff_drive {

/// What a home-made board needs to be told.
struct HomeMadeSettings {
  BaseWiring wiring{{0, false}, {1, false}, 1440.0};  ///< The board's left and right; counts are those of its encoders.
  std::chrono::milliseconds motor_watchdog{500};      ///< 0 leaves the board's own.
  std::chrono::milliseconds state_period{20};         ///< Framed: how often the board reports its wheels.
};

/// A home-made board with the framed protocol of docs/motor_board_protocol.md. The board reports its state by itself.
class FramedBoard final : public MotorBoard {
 public:
  explicit FramedBoard(const HomeMadeSettings& settings);

  void restart() override { decoder_.restart(); }
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return stop_frame_; }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t index) override;
  [[nodiscard]] ByteView separator() const override { return separator_; }
  [[nodiscard]] double max_wheel_rate() const override { return 1000.0; }
  [[nodiscard]] double position_wrap_rad() const override { return 4294967296.0 * settings_.wiring.rad_per_count(); }
  [[nodiscard]] Stats stats() const override { return {decoder_.stats().bytes, decoder_.stats().lost_bytes}; }

 private:
  const HomeMadeSettings settings_;
  MotorFramePrinter printer_;
  MotorFrameDecoder decoder_;
  std::array<std::uint8_t, 5> stop_frame_{};
  // So many zeros end any frame of ours, and no zero begins one.
  std::array<std::uint8_t, MotorFramePrinter::kLongest> separator_{};
};

/// A home-made board with the text protocol of docs/motor_board_protocol.md: `M left right` to it, `E left right` from it.
///
/// Lines have no checksum, so a damaged command may move the wheels: the framed protocol is the better one.
class TextBoard final : public MotorBoard {
 public:
  explicit TextBoard(const HomeMadeSettings& settings) : settings_(settings) {}

  void restart() override;
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override;
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t index) override;
  [[nodiscard]] ByteView separator() const override { return kLineEnd; }
  [[nodiscard]] double max_wheel_rate() const override { return 1000.0; }
  [[nodiscard]] double position_wrap_rad() const override { return 4294967296.0 * settings_.wiring.rad_per_count(); }
  [[nodiscard]] Stats stats() const override;

 private:
  struct Counts {
    MonotonicTime at{};
    double left = 0.0, right = 0.0;
  };
  void take(const NumberLine& line, MonotonicTime received_at, BoardEars& ears);

  const HomeMadeSettings settings_;
  NumberLinePrinter commands_;
  NumberLineDecoder decoder_;
  std::optional<Counts> last_;  // for the rates of a board that sends counts only
  WheelRates rates_;
};

}  // namespace nacelle::diff_drive
