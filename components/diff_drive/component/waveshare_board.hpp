// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/protocol/waveshare_command.hpp"
#include "diff_drive/protocol/waveshare_feedback.hpp"

namespace nacelle::diff_drive {

/// A Waveshare UGV board. It speaks of the wheel's rim in m/s and m; the radius it is given turns them into rad.
class WaveshareBoard final : public MotorBoard {
 public:
  struct Settings {
    double wheel_radius_m = 0.033;                  ///< As configured in the board. Must be positive.
    std::chrono::milliseconds motor_watchdog{500};  ///< The board stops after this silence of ours; 0 leaves its 3 s.
  };
  explicit WaveshareBoard(Settings settings);

  void restart() override { decoder_.restart(); }
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return kWaveshareStopFrame; }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t index) override;
  [[nodiscard]] ByteView separator() const override;
  [[nodiscard]] double max_wheel_rate() const override {
    return kWaveshareMaxWheelSpeed_mps / settings_.wheel_radius_m;
  }
  [[nodiscard]] Stats stats() const override;

 private:
  const Settings settings_;
  WaveshareCommandPrinter printer_;
  WaveshareLineDecoder decoder_;
};

}  // namespace nacelle::diff_drive
