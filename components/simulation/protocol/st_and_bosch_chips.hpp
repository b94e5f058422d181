// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "simulation/protocol/register_chip.hpp"

namespace nacelle::simulation {

/// LSM6DSOX. Source: DS12814 rev 4.
class Lsm6dsoxChip final : public RegisterChip {
 public:
  Lsm6dsoxChip() { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;
  /// How much faster its clock runs than it should.
  double clock_error = 0.0;

 private:
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;
  std::uint8_t after(std::uint8_t reg) override;
  void measure(const ImuTruth& truth);
  void push(unsigned sensor, const std::array<std::uint8_t, 6>& data);

  SampleClock clock_;
  double time_s_ = 0.0, measured_s_ = 0.0;
  unsigned slot_ = 0;
  std::deque<std::array<std::uint8_t, 7>> fifo_;
  std::array<std::uint8_t, 7> word_{};  // that is being read
};

/// LIS3MDL. Source: DocID024204 rev 6.
class Lis3mdlChip final : public RegisterChip {
 public:
  Lis3mdlChip() { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;

 private:
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;
  std::uint8_t after(std::uint8_t reg) override {
    return (reg & 0x80U) == 0 ? reg : static_cast<std::uint8_t>(0x80U | (reg + 1U));
  }

  SampleClock clock_;
};

/// The accelerometer of a BMI088. Source: BST-BMI088-DS001 rev 1.9.
class Bmi088AccelChip final : public RegisterChip {
 public:
  Bmi088AccelChip() { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;

 private:
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;
  std::uint8_t after(std::uint8_t reg) override { return reg == 0x26 ? reg : static_cast<std::uint8_t>(reg + 1); }

  SampleClock clock_;
  std::deque<std::uint8_t> fifo_;
};

/// The gyro of a BMI088.
class Bmi088GyroChip final : public RegisterChip {
 public:
  Bmi088GyroChip() { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;

 private:
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;
  std::uint8_t after(std::uint8_t reg) override { return reg == 0x3F ? reg : static_cast<std::uint8_t>(reg + 1); }

  SampleClock clock_;
  std::deque<std::uint8_t> fifo_;
};

/// BNO055, on I2C or on its serial line. Source: BST-BNO055-DS000 rev 1.4.
class Bno055Chip final : public RegisterChip {
 public:
  Bno055Chip() { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;
  /// Takes bytes of the host on the serial line and returns the answer, if a request is complete.
  [[nodiscard]] Bytes serial(ByteView bytes);
  /// The next requests on the serial line that are answered with "bus overrun".
  int overruns = 0;

 private:
  void reset() override;
  void write(std::uint8_t reg, std::uint8_t value) override;

  SampleClock clock_;
  Bytes request_;
};

/// One frame of a BNO08x in mode UART-RVC. Angles in degrees, acceleration in g. Source: BNO080 data sheet, page 21.
[[nodiscard]] std::array<std::uint8_t, 19> print_rvc(std::uint8_t index,
                                                     const std::array<double, 3>& yaw_pitch_roll_deg,
                                                     const std::array<double, 3>& acceleration_g);

}  // namespace nacelle::simulation
