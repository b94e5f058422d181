// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "simulation/protocol/motor_device.hpp"

namespace nacelle::simulation {

/// A Hiwonder RRC whose first motor turns the left wheel and whose second one turns the right wheel.
///
/// It counts its encoders for its own speed controllers and does not report them, and it has no watchdog. It reports its IMU a hundred times a second and
/// its battery about once.
/// Written from the device's side on purpose: the driver's encoder and decoder are another reading of the same description.
/// Source: Hiwonder, the RRC's firmware: packet.c (frames), packet_handle.c (commands), battery_handle.c.
class HiwonderDevice final : public MotorDevice {
 public:
  [[nodiscard]] Bytes on_bytes(ByteView bytes, Duration now) override;
  [[nodiscard]] Bytes step(Duration now, double left_angle_rad, double right_angle_rad) override;
  [[nodiscard]] double left_target_rps() const override { return speed_of(0); }
  [[nodiscard]] double right_target_rps() const override { return speed_of(1); }
  /// Units: rad/s.
  [[nodiscard]] double speed_of(std::size_t motor) const;

  void set_battery_mv(std::uint16_t battery_mv) { battery_mv_ = battery_mv; }
  /// A board whose IMU is broken reports its battery only.
  void break_imu() { has_imu_ = false; }
  /// It says nothing any more.
  void silence(bool silent) { is_silent_ = silent; }
  [[nodiscard]] std::uint64_t commands() const { return commands_; }
  [[nodiscard]] std::uint64_t bad_frames() const { return bad_frames_; }

 private:
  enum class Awaited : std::uint8_t { First, Second, Function, Length, Data, Check };
  void take(std::uint8_t byte);
  void obey();

  Awaited awaited_ = Awaited::First;
  std::uint8_t function_ = 0, length_ = 0;
  Bytes data_;
  std::array<float, 4> turns_per_s_{};
  std::uint16_t battery_mv_ = 7400;
  bool has_imu_ = true, is_silent_ = false;
  Duration battery_at_{};
  std::uint64_t commands_ = 0, bad_frames_ = 0;
};

}  // namespace nacelle::simulation
