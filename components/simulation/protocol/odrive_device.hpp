// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "simulation/protocol/motor_device.hpp"

namespace nacelle::simulation {

/// An ODrive 3.x with firmware 0.5, as its ASCII protocol shows it: axis 0 turns the left wheel, axis 1 the right one.
///
/// Written from the device's side on purpose: the driver's reading of the protocol is another one.
/// Source: ODrive documentation, ASCII protocol; AxisState and the watchdog of its reference.
class OdriveDevice final : public MotorDevice {
 public:
  struct Settings {
    bool answers_checksums = true;  ///< To commands with one.
  };
  struct Axis {
    int state = 1;  ///< 1 idle, 8 closed loop control
    std::uint32_t error = 0;
    bool is_calibrated = true;
    bool has_watchdog = false;
    double watchdog_s = 0.0;
    int control_mode = 3, input_mode = 1;
    double target_tps = 0.0;  ///< turns/s
    double position_t = 0.0, velocity_tps = 0.0;
    Duration fed{};
  };

  explicit OdriveDevice(const Settings& settings) : settings_(settings) {}

  [[nodiscard]] Bytes on_bytes(ByteView bytes, Duration now) override;
  [[nodiscard]] Bytes step(Duration now, double left_angle_rad, double right_angle_rad) override;
  [[nodiscard]] double left_target_rps() const override { return target_rps(0); }
  [[nodiscard]] double right_target_rps() const override { return target_rps(1); }

  Axis& axis(std::size_t index) { return axes_[index]; }
  [[nodiscard]] std::uint64_t bad_lines() const { return bad_lines_; }

 private:
  [[nodiscard]] std::string obey(const std::string& command, Duration now);
  [[nodiscard]] std::string write(const std::string& property, double value);
  [[nodiscard]] std::string read(const std::string& property) const;
  [[nodiscard]] double target_rps(std::size_t index) const;

  const Settings settings_;
  std::string line_;
  std::array<Axis, 2> axes_;
  Duration stepped_{};
  std::uint64_t bad_lines_ = 0;
};

}  // namespace nacelle::simulation
