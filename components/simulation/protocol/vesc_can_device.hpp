// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "simulation/protocol/can_wire.hpp"
#include "simulation/protocol/motor_device.hpp"

namespace nacelle::simulation {

/// Two VESCs on a CAN bus: the first turns the left wheel, the second the right one.
///
/// Written from the device's side on purpose: the driver's reading of the protocol is another one. Bytes are frames of 16 bytes.
/// Source: vedderb/bldc, documentation/comm_can.md; comm/comm_can.c (status thread, short buffers), comm/commands.c, timeout.c.
class VescCanDevice final : public MotorDevice {
 public:
  struct Settings {
    std::array<std::uint8_t, 2> ids{7, 42};
    int pole_pairs = 15;
    double full_duty_rps = 60.0;
    Duration timeout = 1000ms;         ///< source: the default in VESC Tool
    Duration status_period = 20ms;     ///< of all status messages
    std::array<Duration, 2> phases{};  ///< of them, against each other
  };

  explicit VescCanDevice(const Settings& settings) : settings_(settings), stated_(settings.phases) {}

  [[nodiscard]] Bytes on_bytes(ByteView bytes, Duration now) override;
  [[nodiscard]] Bytes step(Duration now, double left_angle_rad, double right_angle_rad) override;
  [[nodiscard]] double left_target_rps() const override { return faults_[0] != 0 ? 0.0 : targets_rps_[0]; }
  [[nodiscard]] double right_target_rps() const override { return faults_[1] != 0 ? 0.0 : targets_rps_[1]; }

  void set_fault(std::size_t motor, std::uint8_t code) { faults_[motor] = code; }
  void set_voltage(double volts) { volts_ = volts; }
  /// It hears and says nothing: its cable is out.
  void set_silent(std::size_t motor, bool silent) { is_silent_[motor] = silent; }
  [[nodiscard]] std::uint64_t timeouts() const { return timeouts_; }

 private:
  void obey(std::size_t motor, unsigned command, const Bytes& data, Duration now, Bytes& answers);
  void send_status(std::size_t motor, Bytes& bytes) const;

  const Settings settings_;
  CanWire wire_;
  std::array<double, 2> targets_rps_{}, angles_rad_{}, rates_rps_{};
  std::array<Duration, 2> commanded_{}, stated_{};
  std::array<std::uint8_t, 2> faults_{};
  std::array<bool, 2> is_silent_{};
  Duration stepped_{};
  double volts_ = 24.0;
  std::uint64_t timeouts_ = 0;
};

}  // namespace nacelle::simulation
