// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/st_and_bosch_chips.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::simulation {
namespace {

std::array<std::uint8_t, 6> six(const std::array<int, 3>& values) {
  std::array<std::uint8_t, 6> bytes{};
  for (std::size_t i = 0; i < 3; ++i) store_le16(bytes.data() + 2 * i, static_cast<std::uint16_t>(values[i]));
  return bytes;
}

std::array<int, 3> counts(const std::array<double, 3>& values, double per_unit) {
  return {saturated(values[0] * per_unit), saturated(values[1] * per_unit), saturated(values[2] * per_unit)};
}

// Output data rates by the upper four bits of CTRL1_XL and CTRL2_G.
constexpr double kLsmRatesHz[] = {0, 12.5, 26, 52, 104, 208, 416, 833, 1660, 3330, 6660, 0, 0, 0, 0, 0};

}  // namespace

void Lsm6dsoxChip::reset() {
  registers_ = {};
  registers_[0x0F] = 0x6C;
  registers_[0x12] = 0x04;
  fifo_.clear();
  time_s_ = measured_s_ = 0.0;
}

std::uint8_t Lsm6dsoxChip::read(std::uint8_t reg) {
  const auto level = fifo_.size();
  if (reg == 0x3A) return static_cast<std::uint8_t>(level);
  if (reg == 0x3B) return static_cast<std::uint8_t>(level >> 8U & 3U);
  if (reg >= 0x78 && reg <= 0x7E) {
    if (reg == 0x78) {
      word_ = {};
      if (!fifo_.empty()) {
        word_ = fifo_.front();
        fifo_.pop_front();
      }
    }
    return word_[reg - 0x78U];
  }
  return registers_[reg];
}

std::uint8_t Lsm6dsoxChip::after(std::uint8_t reg) {
  if ((registers_[0x12] & 0x04U) == 0) return reg;
  // A burst over the FIFO's output goes round in it.
  return reg == 0x7E ? 0x78 : static_cast<std::uint8_t>(reg + 1);
}

void Lsm6dsoxChip::write(std::uint8_t reg, std::uint8_t value) {
  if (reg == 0x0F) return;
  registers_[reg] = value;
  if (reg == 0x12 && (value & 0x01U) != 0) reset();
  if (reg == 0x0A && (value & 0x07U) == 0) fifo_.clear();
}

void Lsm6dsoxChip::push(unsigned sensor, const std::array<std::uint8_t, 6>& data) {
  std::array<std::uint8_t, 7> word{};
  unsigned tag = sensor << 3U | slot_ << 1U;
  unsigned parity = 0;
  for (unsigned bits = tag; bits != 0; bits >>= 1U) parity ^= bits & 1U;
  tag |= parity;
  word[0] = static_cast<std::uint8_t>(tag);
  std::ranges::copy(data, word.begin() + 1);
  fifo_.push_back(word);
  if (fifo_.size() > 438) fifo_.pop_front();  // 3 kB
}

void Lsm6dsoxChip::measure(const ImuTruth& truth) {
  constexpr double kMgPerCount[] = {0.061, 0.488, 0.122, 0.244};
  constexpr double kMdpsPerCount[] = {8.75, 4.375, 17.5, 0, 35, 0, 70, 0};
  const auto acceleration = counts(truth.acceleration_g, 1000.0 / kMgPerCount[registers_[0x10] >> 2U & 3U]);
  const auto rate = counts(truth.rate_dps, 1000.0 / kMdpsPerCount[registers_[0x11] >> 1U & 7U]);
  store_le(0x20, saturated((truth.temperature_c - 25.0) * 256.0));
  for (std::uint8_t i = 0; i < 3; ++i) {
    store_le(static_cast<std::uint8_t>(0x22 + 2 * i), rate[i]);
    store_le(static_cast<std::uint8_t>(0x28 + 2 * i), acceleration[i]);
  }
  if ((registers_[0x0A] & 0x07U) != 0x06) return;
  slot_ = (slot_ + 1) & 3U;
  if ((registers_[0x09] & 0xF0U) != 0) push(1, six(rate));
  if ((registers_[0x09] & 0x0FU) != 0) push(2, six(acceleration));
  if ((registers_[0x0A] & 0xC0U) == 0x40 && (registers_[0x19] & 0x20U) != 0) {
    const auto ticks = static_cast<std::uint32_t>(std::llround(measured_s_ / 25e-6));
    std::array<std::uint8_t, 6> bytes{};
    store_le16(bytes.data(), static_cast<std::uint16_t>(ticks));
    store_le16(bytes.data() + 2, static_cast<std::uint16_t>(ticks >> 16U));
    push(4, bytes);
  }
}

void Lsm6dsoxChip::advance(double dt_s, const ImuTruth& truth) {
  const double rate_hz = kLsmRatesHz[registers_[0x11] >> 4U];
  const double own_s = dt_s * (1.0 + clock_error);
  time_s_ += own_s;
  if (rate_hz == 0.0) return;
  for (int n = clock_.tick(own_s, rate_hz); n > 0; --n) {
    // A long pause of measuring is no time between two of them.
    measured_s_ = std::max(measured_s_ + 1.0 / rate_hz, time_s_ - own_s);
    measure(truth);
  }
}

void Lis3mdlChip::reset() {
  registers_ = {};
  registers_[0x0F] = 0x3D;
  registers_[0x20] = 0x10;
  registers_[0x22] = 0x03;
}

std::uint8_t Lis3mdlChip::read(std::uint8_t reg) {
  const std::uint8_t at = reg & 0x7FU;
  const std::uint8_t value = registers_[at];
  if (at == 0x2D) registers_[0x27] &= 0xF7U;
  return value;
}

void Lis3mdlChip::write(std::uint8_t reg, std::uint8_t value) {
  const std::uint8_t at = reg & 0x7FU;
  registers_[at] = value;
  if (at == 0x21 && (value & 0x04U) != 0) reset();
}

void Lis3mdlChip::advance(double dt_s, const ImuTruth& truth) {
  if ((registers_[0x22] & 0x03U) != 0) return;  // powered down
  constexpr double kRatesHz[] = {0.625, 1.25, 2.5, 5, 10, 20, 40, 80};
  if (clock_.tick(dt_s, kRatesHz[registers_[0x20] >> 2U & 7U]) == 0) return;
  constexpr double kPerGauss[] = {6842, 3421, 2281, 1711};
  const auto field = counts(truth.field_ut, kPerGauss[registers_[0x21] >> 5U & 3U] / 100.0);
  for (std::uint8_t i = 0; i < 3; ++i) store_le(static_cast<std::uint8_t>(0x28 + 2 * i), field[i]);
  registers_[0x27] |= 0x08U;
}

void Bmi088AccelChip::reset() {
  registers_ = {};
  registers_[0x00] = 0x1E;
  registers_[0x40] = 0xA8;
  registers_[0x41] = 0x01;
  registers_[0x48] = 0x02;
  registers_[0x49] = 0x10;
  registers_[0x7C] = 0x03;
  fifo_.clear();
}

std::uint8_t Bmi088AccelChip::read(std::uint8_t reg) {
  if (reg == 0x24) return static_cast<std::uint8_t>(fifo_.size());
  if (reg == 0x25) return static_cast<std::uint8_t>(fifo_.size() >> 8U & 0x3FU);
  if (reg == 0x26) {
    if (fifo_.empty()) return 0x80;
    const std::uint8_t byte = fifo_.front();
    fifo_.pop_front();
    return byte;
  }
  return registers_[reg];
}

void Bmi088AccelChip::write(std::uint8_t reg, std::uint8_t value) {
  if (reg == 0x7E) {
    if (value == 0xB6) reset();
    if (value == 0xB0) fifo_.clear();
    return;
  }
  registers_[reg] = value;
}

void Bmi088AccelChip::advance(double dt_s, const ImuTruth& truth) {
  if (registers_[0x7C] != 0x00 || registers_[0x7D] != 0x04) return;
  const double rate_hz = std::exp2(static_cast<double>(registers_[0x40] & 0x0FU) - 5.0) * 12.5;
  for (int n = clock_.tick(dt_s, rate_hz); n > 0; --n) {
    const double range_g = 3.0 * static_cast<double>(1U << (registers_[0x41] & 3U));
    const auto bytes = six(counts(truth.acceleration_g, 32768.0 / range_g));
    std::ranges::copy(bytes, registers_.begin() + 0x12);
    const int temperature = static_cast<int>(std::lround((truth.temperature_c - 23.0) / 0.125));
    const auto eleven = static_cast<unsigned>(temperature < 0 ? temperature + 2048 : temperature);
    registers_[0x22] = static_cast<std::uint8_t>(eleven >> 3U);
    registers_[0x23] = static_cast<std::uint8_t>((eleven & 7U) << 5U);
    if ((registers_[0x49] & 0x40U) == 0) continue;
    fifo_.push_back(0x84);
    fifo_.insert(fifo_.end(), bytes.begin(), bytes.end());
    while (fifo_.size() > 1024) fifo_.erase(fifo_.begin(), fifo_.begin() + 7);
  }
}

void Bmi088GyroChip::reset() {
  registers_ = {};
  registers_[0x00] = 0x0F;
  registers_[0x10] = 0x80;
  fifo_.clear();
}

std::uint8_t Bmi088GyroChip::read(std::uint8_t reg) {
  if (reg == 0x0E) return static_cast<std::uint8_t>(fifo_.size() / 6);
  if (reg == 0x3F) {
    if (fifo_.empty()) return 0;
    const std::uint8_t byte = fifo_.front();
    fifo_.pop_front();
    return byte;
  }
  return registers_[reg];
}

void Bmi088GyroChip::write(std::uint8_t reg, std::uint8_t value) {
  if (reg == 0x14) {
    if (value == 0xB6) reset();
    return;
  }
  if (reg == 0x3E) fifo_.clear();
  registers_[reg] = value;
}

void Bmi088GyroChip::advance(double dt_s, const ImuTruth& truth) {
  if (registers_[0x11] != 0x00) return;
  constexpr double kRatesHz[] = {2000, 2000, 1000, 400, 200, 100, 200, 100};
  constexpr double kRangesDps[] = {2000, 1000, 500, 250, 125, 0, 0, 0};
  for (int n = clock_.tick(dt_s, kRatesHz[registers_[0x10] & 7U]); n > 0; --n) {
    const auto bytes = six(counts(truth.rate_dps, 32767.0 / kRangesDps[registers_[0x0F] & 7U]));
    std::ranges::copy(bytes, registers_.begin() + 0x02);
    if ((registers_[0x3E] & 0xC0U) != 0x80) continue;
    fifo_.insert(fifo_.end(), bytes.begin(), bytes.end());
    while (fifo_.size() > 600) fifo_.erase(fifo_.begin(), fifo_.begin() + 6);
  }
}

void Bno055Chip::reset() {
  registers_ = {};
  registers_[0x00] = 0xA0;
  registers_[0x3B] = 0x80;
  registers_[0x3D] = 0x10;
}

void Bno055Chip::write(std::uint8_t reg, std::uint8_t value) {
  if (reg == 0x3F && (value & 0x20U) != 0) return reset();
  // Most registers can be written in the mode for configuration only.
  const bool configures = (registers_[0x3D] & 0x0FU) == 0;
  if (configures || reg == 0x3D || reg == 0x07) registers_[reg] = value;
}

void Bno055Chip::advance(double dt_s, const ImuTruth& truth) {
  const unsigned mode = registers_[0x3D] & 0x0FU;
  if (mode < 0x08 || clock_.tick(dt_s, 100.0) == 0) return;
  const bool in_mg = (registers_[0x3B] & 0x01U) != 0, in_rad = (registers_[0x3B] & 0x02U) != 0;
  const auto put = [this](std::uint8_t first, const std::array<int, 3>& values) {
    for (std::uint8_t i = 0; i < 3; ++i) store_le(static_cast<std::uint8_t>(first + 2 * i), values[i]);
  };
  put(0x08, counts(truth.acceleration_g, in_mg ? 1000.0 : 9.80665 * 100.0));
  if (mode == 0x0C) put(0x0E, counts(truth.field_ut, 16.0));
  put(0x14, counts(truth.rate_dps, in_rad ? 900.0 * 3.14159265358979 / 180.0 : 16.0));
  for (std::uint8_t i = 0; i < 4; ++i)
    store_le(static_cast<std::uint8_t>(0x20 + 2 * i), saturated(truth.quaternion[i] * 16384.0));
  registers_[0x34] = static_cast<std::uint8_t>(static_cast<int>(std::lround(truth.temperature_c)));
  registers_[0x35] = 0xFF;
}

Bytes Bno055Chip::serial(ByteView bytes) {
  request_.insert(request_.end(), bytes.begin(), bytes.end());
  if (!request_.empty() && request_[0] != 0xAA) {
    request_.clear();
    return {0xEE, 0x06};
  }
  if (request_.size() < 4) return {};
  const std::uint8_t reg = request_[2], length = request_[3];
  const bool reads = request_[1] == 0x01;
  if (!reads && request_.size() < std::size_t{4} + length) return {};
  const Bytes data(request_.begin() + 4, request_.end());
  request_.clear();
  if (overruns > 0) {
    --overruns;
    return {0xEE, 0x07};
  }
  if (length == 0) return {0xEE, 0x09};
  if (length > 128) return {0xEE, 0x08};
  if (!reads) {
    for (std::size_t i = 0; i < length; ++i) write(static_cast<std::uint8_t>(reg + i), data[i]);
    return {0xEE, 0x01};
  }
  Bytes answer{0xBB, length};
  for (std::size_t i = 0; i < length; ++i) answer.push_back(read(static_cast<std::uint8_t>(reg + i)));
  return answer;
}

std::array<std::uint8_t, 19> print_rvc(std::uint8_t index, const std::array<double, 3>& yaw_pitch_roll_deg,
                                       const std::array<double, 3>& acceleration_g) {
  std::array<std::uint8_t, 19> frame{0xAA, 0xAA, index};
  std::ranges::copy(six(counts(yaw_pitch_roll_deg, 100.0)), frame.begin() + 3);
  std::ranges::copy(six(counts(acceleration_g, 1000.0)), frame.begin() + 9);
  unsigned sum = 0;
  for (std::size_t i = 2; i < 18; ++i) sum += frame[i];
  frame[18] = static_cast<std::uint8_t>(sum);
  return frame;
}

}  // namespace nacelle::simulation
