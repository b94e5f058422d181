// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "simulation/protocol/register_chip.hpp"

namespace nacelle::simulation {

/// MPU-6050 or MPU-9250. Source: RM-MPU-6000A rev 4.2, RM-MPU-9250A rev 1.6.
class MpuChip final : public RegisterChip {
 public:
  explicit MpuChip(bool is_9250) : is_9250_(is_9250) { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;
  /// The compass answers on the same bus.
  [[nodiscard]] bool bypasses() const { return (registers_[0x37] & 0x02U) != 0; }

 private:
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;
  std::uint8_t after(std::uint8_t reg) override { return reg == 0x74 ? reg : static_cast<std::uint8_t>(reg + 1); }
  void measure(const ImuTruth& truth);

  const bool is_9250_;
  SampleClock clock_;
  std::deque<std::uint8_t> fifo_;
};

/// ICM-20948. Source: DS-000189 rev 1.3.
class Icm20948Chip final : public RegisterChip {
 public:
  Icm20948Chip() { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;
  [[nodiscard]] bool bypasses() const { return (registers_[0x0F] & 0x02U) != 0; }

 private:
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;
  std::uint8_t after(std::uint8_t reg) override {
    return bank() == 0 && reg == 0x72 ? reg : static_cast<std::uint8_t>(reg + 1);
  }
  void measure(const ImuTruth& truth);
  [[nodiscard]] unsigned bank() const { return registers_[0x7F] >> 4U & 3U; }

  std::array<std::uint8_t, 128> bank_2_{};
  SampleClock clock_;
  std::deque<std::uint8_t> fifo_;
};

/// AK8963 (in an MPU-9250) or AK09916 (in an ICM-20948). Source: their data sheets.
class CompassChip final : public RegisterChip {
 public:
  explicit CompassChip(bool is_09916) : is_09916_(is_09916) { reset(); }
  void advance(double dt_s, const ImuTruth& truth) override;

 private:
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;

  const bool is_09916_;
  SampleClock clock_;
};

}  // namespace nacelle::simulation
