// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/vl53l0x_chip.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace nacelle::simulation {
namespace {

constexpr std::uint8_t kStopSecret = 0x3C;
constexpr double kTicksPerMs = 1042.0;
constexpr double kCalibration_s = 0.004, kMemory_s = 0.0015;

// A macro period is 2304 times the laser's, whose clock has 1.655 ns.
double macro_s(std::uint8_t laser_register) { return 2304.0 * 2.0 * (laser_register + 1) * 1.655e-9; }
double timeout_of(std::uint8_t exponent, std::uint8_t mantissa) { return std::ldexp(mantissa, exponent) + 1.0; }

}  // namespace

void Vl53l0xChip::reset() {
  pages_ = {};
  auto& front = pages_[0];
  front[0xC0] = 0xEE;
  front[0xC1] = 0xAA;
  front[0xC2] = 0x10;
  front[0x8A] = 0x29;
  front[0x84] = 0x11;
  front[0xF8] = static_cast<std::uint8_t>(static_cast<int>(kTicksPerMs) >> 8);
  front[0xF9] = static_cast<std::uint8_t>(static_cast<int>(kTicksPerMs));
  // Which reference cells work: some do not, as in every part.
  const std::uint8_t cells[] = {0xFE, 0x7F, 0xBF, 0xFF, 0xEF, 0x0F};
  std::copy(std::begin(cells), std::end(cells), front.begin() + 0xB0);
  pages_[1][0x91] = kStopSecret;
  mode_ = Mode::Idle;
  memory_left_s_ = -1.0;
  stops_ = has_voltage_ = has_phase_ = false;
}

// A measurement under way ends; a pause ends at once.
void Vl53l0xChip::stop_in_pause() {
  if (!stops_ || pages_[1][0x91] != 0 || left_s_ <= measurement_s()) return;
  mode_ = Mode::Idle;
  stops_ = false;
}

std::uint8_t Vl53l0xChip::read(std::uint8_t reg) {
  stop_in_pause();
  if (reg == 0xFF) return pages_[0][0xFF];
  const std::size_t now = page();
  if (now == 0 && reg == 0x00) return mode_ == Mode::Timed ? 0x04 : mode_ == Mode::BackToBack ? 0x02 : 0x00;
  if (now == 1 && reg == 0x04) return mode_ == Mode::Idle ? 0x00 : 0x01;
  if (now == 1 && reg == 0x91) return is_opened() ? pages_[1][0x91] : 0x00;
  return pages_[now][reg];
}

void Vl53l0xChip::write(std::uint8_t reg, std::uint8_t value) {
  if (reg == 0xFF || reg == 0x80) {
    pages_[0][reg] = value;
    return;
  }
  const std::size_t now = page();
  if (now == 0 && (reg >= 0xC0 && reg <= 0xC2)) return;  // its names
  if (now == 0 && reg == 0x00) return start(value);
  if (now == 0 && reg == 0x0B && (value & 0x01U) != 0) pages_[0][0x13] = 0;
  if (now == 0 && reg == 0x0B) return;
  pages_[now][reg] = value;
  // The memory of the factory answers a request for its word 6B if the driver has allowed it in page 6.
  if (now == 7 && reg == 0x83 && value == 0 && pages_[7][0x94] == 0x6B && (pages_[6][0x83] & 0x04U) != 0 &&
      pages_[7][0x81] == 0x01)
    memory_left_s_ = kMemory_s;
}

void Vl53l0xChip::start(std::uint8_t how) {
  const std::uint8_t sequence = pages_[0][0x01];
  if (measures() && (how & 0x01U) != 0) {
    stops_ = true;
  } else if ((how & 0x06U) != 0) {
    const bool is_ready =
        has_voltage_ && has_phase_ && pages_[1][0x91] == kStopSecret && sequence == 0xE8 && pages_[0][0x0A] == 0x04;
    if (!is_ready) return;
    mode_ = (how & 0x04U) != 0 ? Mode::Timed : Mode::BackToBack;
    stops_ = false;
    left_s_ = measurement_s();
  } else if ((how == 0x41 && sequence == 0x01) || (how == 0x01 && sequence == 0x02)) {
    mode_ = Mode::Calibrating;
    left_s_ = kCalibration_s;
  } else if (how == 0x01) {
    mode_ = Mode::Single;
    left_s_ = measurement_s();
  } else if (how == 0x00 && mode_ == Mode::Calibrating) {
    mode_ = Mode::Idle;
  }
}

void Vl53l0xChip::finish() {
  auto& front = pages_[0];
  if (mode_ == Mode::Calibrating) {
    if (is_broken_) return;
    (front[0x01] == 0x01 ? has_voltage_ : has_phase_) = true;
    front[0x13] = 0x04;
    mode_ = Mode::Idle;
    return;
  }
  ++measurements_;
  const auto store = [&](std::uint8_t reg, double value) {
    const int whole = std::clamp(static_cast<int>(std::lround(value)), 0, 0xFFFF);
    front[reg] = static_cast<std::uint8_t>(whole >> 8);
    front[reg + 1U] = static_cast<std::uint8_t>(whole);
  };
  front[0x14] = static_cast<std::uint8_t>(sight_.code << 3U | 0x01U);
  store(0x16, sight_.cells * 256.0);
  store(0x1A, sight_.signal_mcps * 128.0);
  store(0x1C, sight_.ambient_mcps * 128.0);
  store(0x1E, sight_.distance_mm);
  front[0x13] = 0x04;
  // Without its secret it does not go on; with it, a stop is not heeded.
  if (mode_ == Mode::Single || (stops_ && pages_[1][0x91] == 0)) {
    mode_ = Mode::Idle;
    stops_ = false;
  } else {
    left_s_ = mode_ == Mode::Timed ? std::max(period_s(), measurement_s()) : measurement_s();
  }
}

void Vl53l0xChip::advance(double dt_s) {
  stop_in_pause();
  if (memory_left_s_ >= 0.0) {
    memory_left_s_ -= dt_s;
    if (memory_left_s_ < 0.0) {
      pages_[7][0x83] = 0x10;
      pages_[7][0x92] = reference_;
    }
  }
  while (mode_ != Mode::Idle && left_s_ <= dt_s) {
    dt_s -= left_s_;
    left_s_ = 0.0;
    finish();
    if (mode_ == Mode::Calibrating) return;  // broken: for ever
  }
  left_s_ -= dt_s;
}

double Vl53l0xChip::measurement_s() const {
  const auto& front = pages_[0];
  const double first_macro = macro_s(front[0x50]), second_macro = macro_s(front[0x70]);
  const double first = timeout_of(front[0x51], front[0x52]);
  const double cells = (front[0x46] + 1) * first_macro + 690e-6;
  const double second = timeout_of(front[0x71], front[0x72]) - first;
  return 1320e-6 + 960e-6 + 2 * cells + (first * first_macro + 660e-6) + (second * second_macro + 550e-6);
}

double Vl53l0xChip::period_s() const {
  double ticks = 0.0;
  for (std::size_t i = 0; i < 4; ++i) ticks = ticks * 256.0 + pages_[0][0x04 + i];
  return ticks / kTicksPerMs * 1e-3;
}

int Vl53l0xChip::cells_on() const {
  int count = 0;
  for (std::size_t i = 0; i < 6; ++i) count += std::popcount(pages_[0][0xB0 + i]);
  return count;
}

int Vl53l0xChip::first_cell() const {
  for (int i = 0; i < 48; ++i) {
    if ((pages_[0][0xB0 + static_cast<std::size_t>(i) / 8] >> (i % 8) & 1) != 0) return i;
  }
  return -1;
}

}  // namespace nacelle::simulation
