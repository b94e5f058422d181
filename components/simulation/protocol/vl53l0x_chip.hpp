// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "simulation/protocol/register_chip.hpp"

namespace nacelle::simulation {

/// VL53L0X: a laser that measures distances, with its pages of registers, its calibrations and its modes.
///
/// It measures only if all that the maker's interface does before was done: the calibrations of voltage and phase, the choice of reference cells,
/// the value that a stop takes away. How long a measurement takes follows from its registers.
/// Source: ST, VL53L0X API (STSW-IMG005), user manual UM2039, data sheet DocID029104.
class Vl53l0xChip final : public RegisterChip {
 public:
  /// What a measurement ends with.
  struct Sight {
    std::uint8_t code = 11;  ///< Of the maker's list of device errors; 11: complete.
    std::uint16_t distance_mm = 1000;
    double signal_mcps = 12.5, ambient_mcps = 0.5;
    double cells = 16.0;
  };

  Vl53l0xChip() { reset(); }
  void advance(double dt_s, const ImuTruth&) override { advance(dt_s); }
  void advance(double dt_s);
  void look_at(const Sight& sight) { sight_ = sight; }
  /// The measurements of the mode that repeats them are under way: light leaves.
  [[nodiscard]] bool measures() const { return mode_ == Mode::BackToBack || mode_ == Mode::Timed; }
  [[nodiscard]] int measurements() const { return measurements_; }
  /// Of one measurement, by the registers.
  [[nodiscard]] double measurement_s() const;
  /// Reference cells that are switched on, the first of them first.
  [[nodiscard]] int cells_on() const;
  [[nodiscard]] int first_cell() const;
  /// What the factory wrote: how many reference cells, behind the aperture or not.
  void set_reference(std::uint8_t told) { reference_ = told; }
  /// Voltage or phase cannot be calibrated: the device never says that it is done.
  void break_calibration(bool broken) { is_broken_ = broken; }

  static constexpr int kPages = 8;
  [[nodiscard]] std::uint8_t value_on(std::size_t page, std::uint8_t reg) const { return pages_[page][reg]; }

 private:
  enum class Mode : std::uint8_t { Idle, Calibrating, Single, BackToBack, Timed };
  void reset() override;
  std::uint8_t read(std::uint8_t reg) override;
  void write(std::uint8_t reg, std::uint8_t value) override;
  void start(std::uint8_t how);
  void finish();
  void stop_in_pause();
  [[nodiscard]] std::size_t page() const { return pages_[0][0xFF] % kPages; }
  [[nodiscard]] bool is_opened() const { return pages_[0][0x80] == 0x01; }
  [[nodiscard]] double period_s() const;

  std::array<std::array<std::uint8_t, 256>, kPages> pages_{};
  Sight sight_{};
  Mode mode_ = Mode::Idle;
  double left_s_ = 0.0;          // of the measurement or calibration under way, with the pause before it
  double memory_left_s_ = -1.0;  // until the factory's memory is read; negative: nobody asked
  bool stops_ = false, has_voltage_ = false, has_phase_ = false, is_broken_ = false;
  std::uint8_t reference_ = 0x80 | 5;
  int measurements_ = 0;
};

}  // namespace nacelle::simulation
