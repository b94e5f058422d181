// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/protocol/roboclaw_answers.hpp"

namespace nacelle::diff_drive {

/// A RoboClaw in packet serial mode, with encoders and a tuned velocity PID.
///
/// Each round of questions reads both speeds, the encoders and the status; once a second also the battery. The next question is asked
/// when the one before is answered. The stop frame sets both duties to zero, which does not depend on the PID.
/// The board's serial timeout is set before the first encoders are read, and again whenever an answer is missing.
class RoboclawBoard final : public MotorBoard {
 public:
  struct Settings {
    std::uint8_t address = 0x80;                    ///< 0x80 to 0x87.
    BaseWiring wiring{{1, false}, {2, false}};      ///< Channels 1 and 2; counts are edges of the encoder (4 per line).
    std::chrono::milliseconds motor_watchdog{500};  ///< Rounded up to 0.1 s; 0 leaves the board's own setting.
    Duration request_period = 15ms;                 ///< Rounds begin at least so far apart.
  };
  explicit RoboclawBoard(const Settings& settings);

  void restart() override;
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return stop_frame_; }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t) override { return {}; }
  [[nodiscard]] ByteView next_request(MonotonicTime now) override;
  void on_commanded(MonotonicTime now, const WheelRates&) override;
  [[nodiscard]] ByteView separator() const override { return separator_; }
  [[nodiscard]] double max_wheel_rate() const override;
  [[nodiscard]] double position_wrap_rad() const override;
  [[nodiscard]] Stats stats() const override { return {answers_.stats().bytes, answers_.stats().lost_bytes}; }

 private:
  enum class Question : std::uint8_t { Timeout, SpeedM1, SpeedM2, Encoders, Status, Battery, None };

  void take(const RoboclawAnswer& answer, BoardEars& ears);
  void give_up_the_missing(MonotonicTime now);
  void expect(RoboclawCommand command, MonotonicTime now);
  [[nodiscard]] ByteView ask(RoboclawCommand command, MonotonicTime now);

  const Settings settings_;
  RoboclawPrinter printer_;
  RoboclawAnswers answers_;
  std::array<std::uint8_t, 8> stop_frame_{};
  // So many zeros end any packet of ours, and none of them is an address: the board reads the packet that follows.
  std::array<std::uint8_t, RoboclawPrinter::kLongest> separator_{};
  Question next_ = Question::Timeout;
  MonotonicTime round_at_{};
  MonotonicTime active_at_{};     // anything was sent or received last
  MonotonicTime awaits_since_{};  // since when the oldest question without an answer is the oldest
  MonotonicTime battery_at_{};
  std::array<std::int32_t, 2> speeds_cps_{};
};

}  // namespace nacelle::diff_drive
