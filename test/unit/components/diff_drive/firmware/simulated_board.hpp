// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "diff_drive/firmware/motor_firmware.hpp"
#include "simulation/protocol/motor_device.hpp"

namespace nacelle::diff_drive {

/// The reference firmware on a board of which the test is the hardware: two motors whose rate follows the duty.
class SimulatedBoard final : public simulation::MotorDevice {
 public:
  static constexpr float kFull_rps = 80.0F;
  static constexpr double kCounts = 4e6;  // so that a rate over 10 ms is as fine as the laws want it

  explicit SimulatedBoard(motor_firmware::Tuning tuning = {static_cast<float>(kCounts), 1.0F / kFull_rps, 0.0F, 0.0F})
      : firmware_({this, &send, &set_duty, &counts, &battery, &faults}, tuning) {}

  Bytes on_bytes(ByteView bytes, Duration now) override {
    sent_.clear();
    for (const std::uint8_t byte : bytes) firmware_.byte(byte, ms(now));
    return sent_;
  }
  Bytes step(Duration now, double left_angle_rad, double right_angle_rad) override {
    sent_.clear();
    const auto count = [](double angle_rad) {
      return static_cast<std::int32_t>(std::llround(angle_rad / (2.0 * std::numbers::pi) * kCounts));
    };
    counts_ = {count(left_angle_rad), count(right_angle_rad)};
    firmware_.tick(ms(now));
    return sent_;
  }
  double left_target_rps() const override { return static_cast<double>(duties_[0]) * kFull_rps; }
  double right_target_rps() const override { return static_cast<double>(duties_[1]) * kFull_rps; }

  motor_firmware::MotorFirmware& firmware() { return firmware_; }
  std::uint16_t battery_mv = 11800, fault_bits = 0;
  [[nodiscard]] const std::array<float, 2>& duties() const { return duties_; }

 private:
  static std::uint32_t ms(Duration now) { return static_cast<std::uint32_t>(now / 1ms); }
  static SimulatedBoard& of(void* board) { return *static_cast<SimulatedBoard*>(board); }
  static void send(void* board, const std::uint8_t* bytes, unsigned count) {
    of(board).sent_.insert(of(board).sent_.end(), bytes, bytes + count);
  }
  static void set_duty(void* board, int wheel, float duty) {
    of(board).duties_[static_cast<std::size_t>(wheel)] = duty;
  }
  static std::int32_t counts(void* board, int wheel) { return of(board).counts_[static_cast<std::size_t>(wheel)]; }
  static std::uint16_t battery(void* board) { return of(board).battery_mv; }
  static std::uint16_t faults(void* board) { return of(board).fault_bits; }

  Bytes sent_;
  std::array<float, 2> duties_{};
  std::array<std::int32_t, 2> counts_{};
  motor_firmware::MotorFirmware firmware_;
};

}  // namespace nacelle::diff_drive
