// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

/// What an IMU feels, in the units of data sheets, along the axes of its accelerometer.
struct ImuTruth {
  std::array<double, 3> acceleration_g{0.0, 0.0, 1.0};
  std::array<double, 3> rate_dps{};
  std::array<double, 3> field_ut{0.0, 20.0, -43.0};
  std::array<double, 4> quaternion{1.0, 0.0, 0.0, 0.0};  ///< w x y z
  double temperature_c = 25.0;
};

/// A chip with registers of a byte, as it behaves on an I2C bus: the first byte written is the register, later ones are values; a read
/// goes on from the register.
class RegisterChip {
 public:
  RegisterChip() = default;
  RegisterChip(const RegisterChip&) = delete;
  RegisterChip& operator=(const RegisterChip&) = delete;
  virtual ~RegisterChip() = default;

  /// Returns whether the chip acknowledges.
  bool transfer(ByteView out, ByteSpan in) {
    if (!has_power_) return false;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (i == 0) {
        pointer_ = out[0];
      } else {
        write(pointer_, out[i]);
        pointer_ = after(pointer_);
      }
    }
    for (auto& byte : in) {
      byte = read(pointer_);
      pointer_ = after(pointer_);
    }
    return true;
  }

  /// Time goes on; what the chip feels is the same all the while.
  virtual void advance(double dt_s, const ImuTruth& truth) = 0;
  /// Takes the power away, or gives it back: all registers then have their first values.
  void set_power(bool on) {
    has_power_ = on;
    if (on) reset();
  }
  [[nodiscard]] std::uint8_t value(std::uint8_t reg) const { return registers_[reg]; }

 protected:
  /// Power-on values.
  virtual void reset() = 0;
  virtual std::uint8_t read(std::uint8_t reg) { return registers_[reg]; }
  virtual void write(std::uint8_t reg, std::uint8_t value) { registers_[reg] = value; }
  virtual std::uint8_t after(std::uint8_t reg) { return static_cast<std::uint8_t>(reg + 1); }

  void store_be(std::uint8_t reg, int value) {
    registers_[reg] = static_cast<std::uint8_t>(value >> 8);
    registers_[reg + 1U] = static_cast<std::uint8_t>(value);
  }
  void store_le(std::uint8_t reg, int value) {
    registers_[reg] = static_cast<std::uint8_t>(value);
    registers_[reg + 1U] = static_cast<std::uint8_t>(value >> 8);
  }

  std::array<std::uint8_t, 256> registers_{};

 private:
  std::uint8_t pointer_ = 0;
  bool has_power_ = true;
};

/// The nearest count, held at the ends of 16 bits.
[[nodiscard]] int saturated(double counts);

/// The times at which a chip measures.
class SampleClock {
 public:
  /// How many measurements fall into the next dt_s.
  int tick(double dt_s, double rate_hz) {
    phase_ += dt_s * rate_hz;
    const int whole = static_cast<int>(phase_ + 1e-9);
    phase_ -= whole;
    return whole;
  }

 private:
  double phase_ = 0.0;
};

}  // namespace nacelle::simulation
