// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "simulation/protocol/motor_device.hpp"

namespace nacelle::simulation {

/// Two VESCs: one on the line, which turns the left wheel, and one on its CAN bus, which turns the right wheel.
///
/// Written from the device's side on purpose: the driver's encoder and decoder are another reading of the same description.
/// Source: vedderb/bldc, comm/packet.c (frames), comm/commands.c (commands), timeout.c.
class VescDevice final : public MotorDevice {
 public:
  struct Settings {
    std::array<std::uint8_t, 2> ids{7, 42};  ///< On the CAN bus: of the one on the line, of the other.
    int pole_pairs = 15;
    double full_duty_rps = 60.0;
    Duration timeout = 1000ms;  ///< source: the default in VESC Tool
  };
  struct Stats {
    std::uint64_t frames = 0, bad_frames = 0, timeouts = 0;
  };

  explicit VescDevice(const Settings& settings) : settings_(settings) {}

  [[nodiscard]] Bytes on_bytes(ByteView bytes, Duration now) override;
  [[nodiscard]] Bytes step(Duration now, double left_angle_rad, double right_angle_rad) override;
  [[nodiscard]] double left_target_rps() const override { return faults_[0] != 0 ? 0.0 : targets_rps_[0]; }
  [[nodiscard]] double right_target_rps() const override { return faults_[1] != 0 ? 0.0 : targets_rps_[1]; }

  void set_fault(std::size_t motor, std::uint8_t code) { faults_[motor] = code; }
  void set_voltage(double volts) { volts_ = volts; }
  /// The second one no longer answers: its CAN cable is out.
  void cut_can(bool cut) { is_can_cut_ = cut; }
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  void obey(std::size_t motor, ByteView payload, Duration now, Bytes& answers);
  [[nodiscard]] Bytes values(std::size_t motor, std::uint32_t mask) const;

  const Settings settings_;
  Bytes buffer_;
  std::array<double, 2> targets_rps_{}, angles_rad_{}, rates_rps_{};
  std::array<Duration, 2> commanded_{};
  std::array<std::uint8_t, 2> faults_{};
  Duration stepped_{};
  double volts_ = 24.0;
  bool is_can_cut_ = false;
  Stats stats_;
};

}  // namespace nacelle::simulation
