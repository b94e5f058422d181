// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "simulation/protocol/motor_device.hpp"

namespace nacelle::simulation {

/// A RoboClaw in packet serial mode with a motor and an encoder on each channel: M1 turns the left wheel, M2 the right.
///
/// Written from the device's side on purpose: the driver's encoder and decoder are another reading of the same description.
/// Source: Basicmicro, RoboClaw user manual, "Packet Serial".
class RoboclawDevice final : public MotorDevice {
 public:
  struct Settings {
    std::uint8_t address = 0x80;
    double counts_per_turn = 1440.0;
    double full_duty_rps = 30.0;    ///< Rate of a wheel at full duty.
    bool has_old_firmware = false;  ///< Its status has 16 bits.
    bool sends_magnitudes = false;  ///< Speeds are magnitudes beside the direction's byte, not signed numbers.
  };
  struct Stats {
    std::uint64_t packets = 0, bad_checksums = 0, torn_packets = 0, stray_bytes = 0, timeouts = 0;
  };

  explicit RoboclawDevice(const Settings& settings) : settings_(settings) {}

  [[nodiscard]] Bytes on_bytes(ByteView bytes, Duration now) override;
  [[nodiscard]] Bytes step(Duration now, double left_angle_rad, double right_angle_rad) override;
  [[nodiscard]] double left_target_rps() const override { return target_rps(0); }
  [[nodiscard]] double right_target_rps() const override { return target_rps(1); }

  /// What command 90 answers; the bits are those of the manual.
  void set_status(std::uint32_t status) { status_ = status; }
  void set_battery(double volts) { tenths_v_ = static_cast<std::uint16_t>(std::lround(volts * 10.0)); }
  /// Power off and on: counters, timeout and motion are gone.
  void restart();
  [[nodiscard]] double timeout_s() const { return 0.1 * timeout_tenths_; }
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  /// Looks at the packet that has begun; returns how many bytes it has, or nothing while more must come.
  [[nodiscard]] std::optional<std::size_t> handle(const Bytes& packet, Bytes& answer);
  void answer_read(const Bytes& packet, const Bytes& data, Bytes& answer) const;
  [[nodiscard]] double target_rps(std::size_t motor) const;
  [[nodiscard]] Bytes speed_of(std::size_t motor) const;

  const Settings settings_;
  Bytes buffer_;
  Duration last_byte_{}, last_packet_{}, stepped_{};
  std::uint8_t timeout_tenths_ = 0;
  std::uint32_t status_ = 0;
  std::uint16_t tenths_v_ = 120;
  std::array<double, 2> targets_cps_{};
  std::array<double, 2> counts_{}, zero_{}, speeds_cps_{};
  Stats stats_;
};

}  // namespace nacelle::simulation
