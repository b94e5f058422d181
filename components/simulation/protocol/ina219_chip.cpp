// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/ina219_chip.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace nacelle::simulation {
namespace {

enum : std::uint8_t { kInaConfig, kInaShunt, kInaBus, kInaPower, kInaCurrent, kInaCalibration };

// The data sheet's table of ADC settings, in microseconds.
double adc_us(unsigned setting) {
  constexpr double kByResolution[] = {84, 148, 276, 532};
  constexpr double kBySamples[] = {532, 1060, 2130, 4260, 8510, 17020, 34050, 68100};
  return (setting & 8U) == 0 ? kByResolution[setting & 3U] : kBySamples[setting & 7U];
}

int clamped(double value, int least, int most) {
  return static_cast<int>(std::lround(std::clamp(value, static_cast<double>(least), static_cast<double>(most))));
}

}  // namespace

void Ina219Chip::reset() {
  registers_ = {0x399F, 0, 0, 0, 0, 0};
  left_s_ = conversion_s();
}

double Ina219Chip::conversion_s() const {
  const unsigned config = registers_[kInaConfig];
  return 1e-6 * (adc_us(config >> 3U & 15U) + adc_us(config >> 7U & 15U));
}

bool Ina219Chip::transfer(ByteView out, ByteSpan in) {
  if (!has_power_) return false;
  if (!out.empty()) pointer_ = out[0];
  for (std::size_t i = 1; i + 1 < out.size(); i += 2)
    write(pointer_, static_cast<std::uint16_t>(out[i] << 8 | out[i + 1]));
  for (std::size_t i = 0; i < in.size(); ++i) {
    const std::uint16_t word = pointer_ < registers_.size() ? registers_[pointer_] : 0xFFFF;
    in[i] = static_cast<std::uint8_t>(i % 2 == 0 ? word >> 8 : word);
  }
  if (!in.empty() && pointer_ == kInaPower) registers_[kInaBus] &= 0xFFFDU;
  return true;
}

void Ina219Chip::write(std::uint8_t reg, std::uint16_t value) {
  if (reg == kInaCalibration) registers_[kInaCalibration] = value & 0xFFFEU;
  if (reg != kInaConfig) return;
  if ((value & 0x8000U) != 0) return reset();
  registers_[kInaConfig] = value & 0x3FFFU;
  registers_[kInaBus] &= 0xFFFDU;
  left_s_ = conversion_s();
}

void Ina219Chip::convert() {
  ++conversions_;
  const unsigned config = registers_[kInaConfig];
  const int range = 4000 * (1 << (config >> 11U & 3U));
  const int shunt = clamped(shunt_v_ / 10e-6, -range, range);
  const int bus = clamped(bus_v_ / 4e-3, 0, (config & 0x2000U) != 0 ? 8000 : 4000);
  const long current = static_cast<long>(shunt) * registers_[kInaCalibration] / 4096;
  const long power = std::labs(current) * bus / 5000;
  const bool overflows = current > 32767 || current < -32768 || power > 65535;
  registers_[kInaShunt] = static_cast<std::uint16_t>(shunt);
  registers_[kInaCurrent] = static_cast<std::uint16_t>(current);
  registers_[kInaPower] = static_cast<std::uint16_t>(power);
  registers_[kInaBus] = static_cast<std::uint16_t>(bus << 3 | 2 | (overflows ? 1 : 0));
}

void Ina219Chip::advance(double dt_s) {
  if (!measures()) return;
  while (left_s_ <= dt_s) {
    dt_s -= left_s_;
    left_s_ = conversion_s();
    convert();
  }
  left_s_ -= dt_s;
}

}  // namespace nacelle::simulation
