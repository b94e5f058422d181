// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "diff_drive/component/motor_board.hpp"
#include "diff_drive/component/wheel_wiring.hpp"
#include "diff_drive/model/wheel_pairing.hpp"
#include "diff_drive/protocol/odrive_can.hpp"

namespace nacelle::diff_drive {

/// Two axes of ODrives on a CAN bus, of one board or of two, with CANSimple (firmware 0.5, 0.6).
///
/// A start clears errors, selects velocity control and requests closed loop control. An axis error is a fault, as is an axis that is not in
/// closed loop control, or whose heartbeat is missing. Wheels are read from the axes' cyclic encoder estimates; an axis that sends none
/// is asked. The voltage is asked for once a second. The stop frame commands both velocities to zero.
/// The watchdog of an axis cannot be armed over CANSimple, but each frame to an axis feeds it.
class OdriveCanBoard final : public MotorBoard {
 public:
  struct Settings {
    BaseWiring wiring{
        {0, false}, {1, false}, 1.0};  ///< Channels are nodes; counts are turns of the motor per turn of the wheel.
    Duration request_period = 15ms;    ///< An axis is asked at most so often.
  };
  explicit OdriveCanBoard(const Settings& settings);

  void restart() override;
  void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) override;
  [[nodiscard]] ByteView stop_frame() const override { return stop_.bytes(); }
  [[nodiscard]] ByteView speed_frame(const WheelRates& rates) override;
  [[nodiscard]] ByteView setup_frame(std::size_t index) override;
  [[nodiscard]] ByteView next_request(MonotonicTime now) override;
  void on_commanded(MonotonicTime now, const WheelRates&) override;
  /// A frame is sent whole or not at all.
  [[nodiscard]] ByteView separator() const override { return {}; }
  [[nodiscard]] double max_wheel_rate() const override { return 1e6; }
  [[nodiscard]] Stats stats() const override { return {decoder_.stats().bytes, decoder_.stats().lost_bytes}; }

 private:
  struct Axis {
    std::uint32_t error = 0;
    std::optional<std::uint8_t> state;
    MonotonicTime beat_at{}, moved_at{};
    OdriveMotion motion;
    bool is_asked = false;  // it sends no estimates by itself, or too few
    int heard_since_asked = 0;
  };
  [[nodiscard]] int node(std::size_t wheel) const;
  [[nodiscard]] std::optional<std::size_t> wheel_of(int sender) const;
  [[nodiscard]] bool is_settled(MonotonicTime now) const { return settled_at_ && now >= *settled_at_; }
  void take(const OdriveHeartbeat& beat, MonotonicTime at);
  [[nodiscard]] bool take(const OdriveMotion& motion, MonotonicTime at);
  [[nodiscard]] static bool must_be_asked(Axis& axis, MonotonicTime now);
  void tell_fault(MonotonicTime now, BoardEars& ears) const;

  const Settings settings_;
  CanFrameList<2> stop_, commands_;
  CanFrameList<3> requests_;
  OdriveCanDecoder decoder_;
  WheelPairing pairing_;
  std::array<Axis, 2> axes_;
  std::optional<MonotonicTime> settled_at_;  // heartbeats before it may tell how the axes were before the start
  MonotonicTime asked_at_{}, voltage_asked_at_{};
};

}  // namespace nacelle::diff_drive
