// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/model/wheel_pairing.hpp"
#include "diff_drive/protocol/vesc_can.hpp"

namespace nacelle::diff_drive {

/// Two VESCs on a CAN bus of the host.
///
/// Wheels are read from the status messages 1 and 5, which VESC Tool switches on (App Settings, General, CAN Status). Both are asked
/// for their fault ten times a second. The stop frame sets both duties to zero. Their own timeout (VESC Tool: App Settings, General,
/// Timeout; 1 s by default) is the watchdog; no command sets it.
class VescCanBoard final : public MotorBoard {
 public:
  struct Settings {
    /// Channels are CAN ids. Counts are steps of the tachometer: 6 * pole pairs * gear ratio a turn.
    BaseWiring wiring{{0, false}, {1, false}};
  };
  explicit VescCanBoard(const Settings& settings);

  void restart() override;
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return stop_.bytes(); }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t) override { return {}; }
  [[nodiscard]] ByteView next_request(MonotonicTime now) override;
  /// A frame is sent whole or not at all.
  [[nodiscard]] ByteView separator() const override { return {}; }
  [[nodiscard]] double max_wheel_rate() const override;
  [[nodiscard]] double position_wrap_rad() const override;
  [[nodiscard]] Stats stats() const override { return {decoder_.stats().bytes, decoder_.stats().lost_bytes}; }

 private:
  struct Wheel {
    std::optional<std::int32_t> erpm;  // since the last travel
    VescTravel travel;
    double travelled_erpm = 0.0;  // when the travel was reported
    std::uint8_t fault = 0;
  };
  [[nodiscard]] std::uint8_t id(std::size_t wheel) const;
  [[nodiscard]] std::optional<std::size_t> wheel_of(std::uint8_t sender) const;
  [[nodiscard]] bool take(const VescTravel& travel, MonotonicTime at);

  const Settings settings_;
  CanFrameList<2> stop_, commands_, requests_;
  VescCanDecoder decoder_;
  WheelPairing pairing_;
  std::array<Wheel, 2> wheels_;
  MonotonicTime asked_at_{};
};

}  // namespace nacelle::diff_drive
