// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::simulation {

/// A motor board as its line and its two motors see it. Times are world times.
///
/// Threads: one. Allocates: yes; the simulated world is a process of its own.
class MotorDevice {
 public:
  MotorDevice() = default;
  MotorDevice(const MotorDevice&) = delete;
  MotorDevice& operator=(const MotorDevice&) = delete;
  virtual ~MotorDevice() = default;

  /// Takes what the host sent, in any chopping. Returns what the board answers at once.
  [[nodiscard]] virtual Bytes on_bytes(ByteView bytes, Duration now) = 0;
  /// Lets time pass: the board's watchdog, its encoders. Returns what the board sends by itself.
  [[nodiscard]] virtual Bytes step(Duration now, double left_angle_rad, double right_angle_rad) = 0;
  /// What the motors aim at. Units: rad/s of the wheels.
  [[nodiscard]] virtual double left_target_rps() const = 0;
  [[nodiscard]] virtual double right_target_rps() const = 0;
};

}  // namespace nacelle::simulation
