// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/protocol/hiwonder_frame.hpp"

namespace nacelle::diff_drive {

/// A Hiwonder RRC (ROS robot controller): four motors with speed controllers, of which two are driven here.
///
/// The board reports nothing about its motors, although it counts their encoders: the states say that the wheels turn as commanded, from the instant
/// at which a command was sent (open loop). They stop when the board's own reports (its IMU, its battery) stop, so that its loss is noticed.
/// The board has no watchdog: its motors keep their speed when the computer or the cable fails.
class HiwonderBoard final : public MotorBoard {
 public:
  struct Settings {
    /// A channel is a motor, 1 to 4. Counts are turns of its output shaft.
    BaseWiring wiring{{1, false}, {2, false}, 1.0};
    Duration state_period = 15ms;  ///< States are at least so far apart.
  };
  /// Reports are missing if none comes for so long: three periods of the battery's, for boards whose IMU is silent.
  static constexpr Duration kReportsWithin = 3200ms;

  explicit HiwonderBoard(const Settings& settings);

  void restart() override;
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  void assume_wheels(MonotonicTime now, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return stop_frame_; }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t) override { return {}; }
  void on_commanded(MonotonicTime now, const WheelRates& rates) override;
  [[nodiscard]] ByteView separator() const override { return separator_; }
  [[nodiscard]] double max_wheel_rate() const override { return 1000.0; }
  [[nodiscard]] Stats stats() const override { return {decoder_.stats().bytes, decoder_.stats().lost_bytes}; }

 private:
  void turn_wheels_until(MonotonicTime now);

  const Settings settings_;
  HiwonderPrinter printer_;
  HiwonderDecoder decoder_;
  std::array<std::uint8_t, HiwonderPrinter::kFrame> stop_frame_{};
  // So many zeros end any frame of ours. Behind the first two bytes alone they are an empty report to the board, which means nothing to it.
  std::array<std::uint8_t, HiwonderPrinter::kFrame> separator_{};
  WheelRates rates_;  // as last commanded
  std::optional<MonotonicTime> turned_until_;
  std::optional<MonotonicTime> heard_at_, stated_at_;
  double left_rad_ = 0.0, right_rad_ = 0.0;
};

}  // namespace nacelle::diff_drive
