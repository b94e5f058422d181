// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "simulation/protocol/can_wire.hpp"
#include "simulation/protocol/motor_device.hpp"

namespace nacelle::simulation {

/// Two axes of an ODrive with firmware 0.5 on a CAN bus: the first turns the left wheel, the second the right one.
///
/// Written from the device's side on purpose: the driver's reading of the protocol is another one. Bytes are frames of 16 bytes.
/// Source: ODrive documentation, CAN Protocol and CAN Guide; axis.cpp (watchdog) and can_simple.cpp of firmware 0.5.
class OdriveCanDevice final : public MotorDevice {
 public:
  struct Settings {
    std::array<std::uint32_t, 2> nodes{0, 1};
    Duration heartbeat = 100ms;
    std::array<Duration, 2> estimates{10ms, 10ms};  ///< Periods of the cyclic encoder estimates; zero: only when asked.
    std::array<Duration, 2> phases{};               ///< Of the estimates, against each other.
    double watchdog_s = 0.0;                        ///< 0: off. Set in odrivetool.
  };
  struct Axis {
    std::uint32_t error = 0;
    std::uint8_t state = 1;  ///< 1 idle, 8 closed loop control
    bool is_calibrated = true;
    std::uint32_t control_mode = 3, input_mode = 1;
    float target_tps = 0.0F;  ///< turns/s
    float position_t = 0.0F, velocity_tps = 0.0F;
    Duration fed{}, beaten{}, estimated{};
    bool is_silent = false;  ///< Its cable is out.
    std::uint64_t beats = 0;
  };

  explicit OdriveCanDevice(const Settings& settings);

  [[nodiscard]] Bytes on_bytes(ByteView bytes, Duration now) override;
  [[nodiscard]] Bytes step(Duration now, double left_angle_rad, double right_angle_rad) override;
  [[nodiscard]] double left_target_rps() const override { return target_rps(0); }
  [[nodiscard]] double right_target_rps() const override { return target_rps(1); }

  Axis& axis(std::size_t index) { return axes_[index]; }
  void set_voltage(float volts) { volts_ = volts; }
  [[nodiscard]] std::uint64_t bad_frames() const { return wire_.bad_frames(); }

 private:
  void obey(std::size_t index, std::uint32_t command, const CanMessage& message, Duration now, Bytes& answers);
  void send(std::size_t index, std::uint32_t command, Bytes data, Bytes& bytes) const;
  void send_estimates(std::size_t index, Bytes& bytes) const;
  [[nodiscard]] double target_rps(std::size_t index) const;

  const Settings settings_;
  CanWire wire_;
  std::array<Axis, 2> axes_;
  std::array<double, 2> turns_{};
  Duration stepped_{};
  float volts_ = 24.0F;
};

}  // namespace nacelle::simulation
