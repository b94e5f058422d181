// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/protocol/vesc_frame.hpp"

namespace nacelle::diff_drive {

/// Two VESCs: one on the line and one behind it on its CAN bus, or both on the bus of the one on the line.
///
/// A state is made of one answer of each; an answer of one alone makes none. The stop frame sets both duties to zero.
/// Their own timeout (VESC Tool: App Settings, General, Timeout; 1 s by default) is the watchdog; no command sets it.
class VescBoard final : public MotorBoard {
 public:
  struct Settings {
    /// A channel is a CAN id, or VescPrinter::kOnTheLine. Counts are steps of the tachometer: 6 * pole pairs * gear ratio a turn.
    BaseWiring wiring{{VescPrinter::kOnTheLine, false}, {1, false}};
    Duration request_period = 15ms;  ///< Values are requested at least so far apart.
  };
  explicit VescBoard(const Settings& settings);

  void restart() override;
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return {stop_frame_.data(), stop_bytes_}; }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t) override { return {}; }
  [[nodiscard]] ByteView next_request(MonotonicTime now) override;
  [[nodiscard]] ByteView separator() const override { return separator_; }
  [[nodiscard]] double max_wheel_rate() const override;
  [[nodiscard]] double position_wrap_rad() const override;
  [[nodiscard]] Stats stats() const override { return {decoder_.stats().bytes, decoder_.stats().lost_bytes}; }

 private:
  void take(const VescValues& values, BoardEars& ears);
  /// 0 left, 1 right, or nothing for a VESC that is neither.
  [[nodiscard]] std::optional<std::size_t> wheel_of(std::uint8_t id) const;

  const Settings settings_;
  VescPrinter printer_;
  VescDecoder decoder_;
  std::array<std::uint8_t, 2 * VescPrinter::kLongestFrame> stop_frame_{};
  std::size_t stop_bytes_ = 0;
  // So many zeros end any frame of ours, and no zero begins one.
  std::array<std::uint8_t, VescPrinter::kLongestFrame> separator_{};
  std::array<std::optional<VescValues>, 2> heard_;  // since the last state
  std::array<std::uint8_t, 2> faults_{};
  MonotonicTime asked_at_{};
};

}  // namespace nacelle::diff_drive
