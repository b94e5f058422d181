// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/invensense_chips.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::simulation {
namespace {

void push_be(std::deque<std::uint8_t>& fifo, int value) {
  fifo.push_back(static_cast<std::uint8_t>(value >> 8));
  fifo.push_back(static_cast<std::uint8_t>(value));
}

// When the FIFO is full the oldest bytes make room, wherever a record ends.
void trim(std::deque<std::uint8_t>& fifo, std::size_t size) {
  while (fifo.size() > size) fifo.pop_front();
}

std::uint8_t pop(std::deque<std::uint8_t>& fifo) {
  if (fifo.empty()) return 0xFF;
  const std::uint8_t byte = fifo.front();
  fifo.pop_front();
  return byte;
}

// Counts per g and per degree a second of the four ranges.
constexpr double kPerG[] = {16384.0, 8192.0, 4096.0, 2048.0};
constexpr double kPerDps[] = {131.0, 65.5, 32.8, 16.4};

}  // namespace

int saturated(double counts) { return static_cast<int>(std::clamp(std::round(counts), -32768.0, 32767.0)); }

void MpuChip::reset() {
  registers_ = {};
  registers_[0x6B] = is_9250_ ? 0x01 : 0x40;
  registers_[0x75] = is_9250_ ? 0x71 : 0x68;
  fifo_.clear();
}

std::uint8_t MpuChip::read(std::uint8_t reg) {
  if (reg == 0x72) return static_cast<std::uint8_t>(fifo_.size() >> 8U);
  if (reg == 0x73) return static_cast<std::uint8_t>(fifo_.size());
  if (reg == 0x74) return pop(fifo_);
  return registers_[reg];
}

void MpuChip::write(std::uint8_t reg, std::uint8_t value) {
  if (reg == 0x75) return;
  registers_[reg] = value;
  if (reg == 0x6B && (value & 0x80U) != 0) reset();
  if (reg == 0x6A && (value & 0x04U) != 0) {
    fifo_.clear();
    registers_[0x6A] = value & 0xFBU;
  }
}

void MpuChip::measure(const ImuTruth& truth) {
  const double per_g = kPerG[registers_[0x1C] >> 3U & 3U], per_dps = kPerDps[registers_[0x1B] >> 3U & 3U];
  for (std::uint8_t i = 0; i < 3; ++i) {
    store_be(static_cast<std::uint8_t>(0x3B + 2 * i), saturated(truth.acceleration_g[i] * per_g));
    store_be(static_cast<std::uint8_t>(0x43 + 2 * i), saturated(truth.rate_dps[i] * per_dps));
  }
  store_be(0x41, saturated(is_9250_ ? (truth.temperature_c - 21.0) * 333.87 : (truth.temperature_c - 36.53) * 340.0));
  const std::uint8_t enabled = registers_[0x23];
  if ((registers_[0x6A] & 0x40U) == 0 || enabled == 0) return;
  const auto push = [&](std::uint8_t from, std::uint8_t to) {
    for (unsigned reg = from; reg <= to; ++reg) fifo_.push_back(registers_[reg]);
  };
  if ((enabled & 0x08U) != 0) push(0x3B, 0x40);
  if ((enabled & 0x80U) != 0) push(0x41, 0x42);
  if ((enabled & 0x40U) != 0) push(0x43, 0x44);
  if ((enabled & 0x20U) != 0) push(0x45, 0x46);
  if ((enabled & 0x10U) != 0) push(0x47, 0x48);
  trim(fifo_, is_9250_ ? 512 : 1024);
}

void MpuChip::advance(double dt_s, const ImuTruth& truth) {
  if ((registers_[0x6B] & 0x40U) != 0) return;  // asleep
  const unsigned filter = registers_[0x1A] & 7U;
  const double clock_hz = filter == 0 || filter == 7 ? 8000.0 : 1000.0;
  for (int n = clock_.tick(dt_s, clock_hz / (1 + registers_[0x19])); n > 0; --n) measure(truth);
}

void Icm20948Chip::reset() {
  registers_ = {};
  bank_2_ = {};
  registers_[0x00] = 0xEA;
  registers_[0x06] = 0x41;
  bank_2_[0x01] = 0x01;
  bank_2_[0x14] = 0x01;
  fifo_.clear();
}

std::uint8_t Icm20948Chip::read(std::uint8_t reg) {
  if (reg == 0x7F) return registers_[0x7F];
  if (bank() == 2) return bank_2_[reg & 0x7FU];
  if (bank() != 0) return 0;
  if (reg == 0x70) return static_cast<std::uint8_t>(fifo_.size() >> 8U);
  if (reg == 0x71) return static_cast<std::uint8_t>(fifo_.size());
  if (reg == 0x72) return pop(fifo_);
  return registers_[reg];
}

void Icm20948Chip::write(std::uint8_t reg, std::uint8_t value) {
  if (reg == 0x7F) {
    registers_[0x7F] = value;
  } else if (bank() == 2) {
    bank_2_[reg & 0x7FU] = value;
  } else if (bank() == 0 && reg != 0x00) {
    registers_[reg] = value;
    if (reg == 0x06 && (value & 0x80U) != 0) reset();
    if (reg == 0x68 && (value & 0x1FU) != 0) fifo_.clear();
  }
}

void Icm20948Chip::measure(const ImuTruth& truth) {
  const double per_g = kPerG[bank_2_[0x14] >> 1U & 3U], per_dps = kPerDps[bank_2_[0x01] >> 1U & 3U];
  std::array<int, 7> values{};
  for (std::size_t i = 0; i < 3; ++i) {
    values[i] = saturated(truth.acceleration_g[i] * per_g);
    values[3 + i] = saturated(truth.rate_dps[i] * per_dps);
  }
  values[6] = saturated((truth.temperature_c - 21.0) * 333.87);
  for (std::uint8_t i = 0; i < 7; ++i) store_be(static_cast<std::uint8_t>(0x2D + 2 * i), values[i]);
  const std::uint8_t enabled = registers_[0x67];
  if ((registers_[0x03] & 0x40U) == 0 || (registers_[0x68] & 0x1FU) != 0) return;
  for (std::size_t i = 0; i < 7; ++i) {
    const std::uint8_t bit = i < 3 ? 0x10 : i == 3 ? 0x02 : i == 4 ? 0x04 : i == 5 ? 0x08 : 0x01;
    if ((enabled & bit) != 0) push_be(fifo_, values[i]);
  }
  trim(fifo_, 512);
}

void Icm20948Chip::advance(double dt_s, const ImuTruth& truth) {
  if ((registers_[0x06] & 0x40U) != 0) return;  // asleep
  for (int n = clock_.tick(dt_s, 1100.0 / (1 + bank_2_[0x00])); n > 0; --n) measure(truth);
}

void CompassChip::reset() {
  registers_ = {};
  registers_[0x00] = 0x48;
  if (is_09916_) registers_[0x01] = 0x09;
}

std::uint8_t CompassChip::read(std::uint8_t reg) {
  const std::uint8_t value = registers_[reg];
  // Reading the second status says that the measurement was read.
  if (reg == (is_09916_ ? 0x18 : 0x09)) registers_[is_09916_ ? 0x10 : 0x02] &= 0xFEU;
  return value;
}

void CompassChip::write(std::uint8_t reg, std::uint8_t value) {
  registers_[reg] = value;
  if (is_09916_ && reg == 0x32 && (value & 1U) != 0) reset();
}

void CompassChip::advance(double dt_s, const ImuTruth& truth) {
  const bool runs = is_09916_ ? registers_[0x31] == 0x08 : (registers_[0x0A] & 0x0FU) == 0x06;
  if (!runs || clock_.tick(dt_s, 100.0) == 0) return;
  const auto& field = truth.field_ut;
  // The axes of the magnetometers are not those of the accelerometers (figures "Orientation of axes").
  const std::array<double, 3> seen = is_09916_ ? std::array<double, 3>{field[0], -field[1], -field[2]}
                                               : std::array<double, 3>{field[1], field[0], -field[2]};
  const std::uint8_t first = is_09916_ ? 0x11 : 0x03;
  for (std::uint8_t i = 0; i < 3; ++i) store_le(static_cast<std::uint8_t>(first + 2 * i), saturated(seen[i] / 0.15));
  registers_[is_09916_ ? 0x10 : 0x02] |= 0x01U;
}

}  // namespace nacelle::simulation
