// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/protocol/number_lines.hpp"

namespace nacelle::diff_drive {

/// An ODrive 3.x (firmware 0.5) with two axes, over its ASCII protocol on USB or a UART.
///
/// A start clears errors, selects velocity control, arms the watchdog of both axes and requests closed loop control. An axis that is
/// not in closed loop control is a fault, as is an axis error. Each round asks both axes for position and velocity and, in turn, one of:
/// errors, states, voltage. One question is asked at a time, since an answer does not say what it answers.
/// Commands carry checksums. An ODrive answers such a question with one; an answer without is taken too.
class OdriveBoard final : public MotorBoard {
 public:
  struct Settings {
    BaseWiring wiring{
        {0, false}, {1, false}, 1.0};  ///< Axes 0 and 1; counts are turns of the motor per turn of the wheel.
    std::chrono::milliseconds motor_watchdog{500};  ///< 0 leaves the watchdog off.
    Duration request_period = 15ms;                 ///< Rounds begin at least so far apart.
  };
  explicit OdriveBoard(const Settings& settings);

  void restart() override;
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return stop_.lines(); }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t index) override;
  [[nodiscard]] ByteView next_request(MonotonicTime now) override;
  [[nodiscard]] ByteView separator() const override;
  [[nodiscard]] double max_wheel_rate() const override { return 1e6; }
  [[nodiscard]] Stats stats() const override;

 private:
  enum class Question : std::uint8_t { LeftMotion, RightMotion, Slow, None };
  static constexpr std::size_t kSlowQuestions = 5;  // error of each axis, state of each axis, voltage

  [[nodiscard]] int axis(std::size_t wheel) const;
  void take(const NumberLine& line, BoardEars& ears);
  void take_slow(double value, BoardEars& ears);
  void tell_fault(BoardEars& ears) const;
  void go_on();

  const Settings settings_;
  NumberLinePrinter stop_, commands_, question_;
  NumberLineDecoder decoder_;
  Question next_ = Question::LeftMotion;
  std::size_t slow_ = 0;
  bool awaits_ = false;
  MonotonicTime asked_at_{}, round_at_{}, silent_until_{};
  std::array<double, 2> left_motion_{};  // position, velocity
  std::array<double, 2> errors_{};
  std::array<double, 2> states_{};
  std::array<bool, 2> has_state_{};
};

}  // namespace nacelle::diff_drive
