// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "nacelle/io/register_bus.hpp"
#include "range/protocol/vl53l0x_decoder.hpp"

namespace nacelle::range {

/// Why a VL53L0X cannot be used, in words. `fault` is NotUsable if no wait mends that.
struct Vl53l0xProblem {
  io::StreamFault fault = io::StreamFault::NoAnswer;
  std::string what, way_out;
};

/// A VL53L0X: a laser and a detector that time light, on a bus.
///
/// The order is set_up(), start(), read() ... read(), stop(). After a loss of power it begins anew.
/// Source:    ST, VL53L0X API (STSW-IMG005): DataInit, StaticInit, PerformRefCalibration, StartMeasurement, StopMeasurement; register names
///            in its vl53l0x_device.h. The cells that the maker calibrated at the factory are used; a cover glass would want its own.
/// Threads:   one. Allocates: nothing, but for the words of a problem.
class Vl53l0x {
 public:
  struct Settings {
    std::uint8_t address = 0x29;
    Duration period = 100ms;  ///< From one measurement to the next; longer than the budget.
    Duration budget = 33ms;   ///< Of one measurement, 20 ms at the least: twice as long is 1.4 times as exact.
  };
  Vl53l0x(io::RegisterBus& bus, const Settings& settings, const Clock& clock)
      : bus_(bus), settings_(settings), clock_(clock) {}

  /// Identifies the device, gives it its settings and calibrates it. Takes some 50 ms, a second at the most.
  [[nodiscard]] Result<void, Vl53l0xProblem> set_up();
  /// Measures from now on, by the device's clock.
  [[nodiscard]] Result<void, Vl53l0xProblem> start();
  /// Ends measuring: no light leaves any more.
  [[nodiscard]] Result<void, Vl53l0xProblem> stop();
  /// Returns whether there was a new result, which is in `record` then, to be decoded. A transfer that fails is tried once more.
  [[nodiscard]] Result<bool, io::StreamFault> read(std::array<std::uint8_t, Vl53l0xDecoder::kRecordBytes>& record);
  /// Transfers that worked when read() tried them again. Threads: the one that reads.
  [[nodiscard]] std::uint64_t retries() const { return retries_; }

 private:
  io::RegisterBus& bus_;
  const Settings settings_;
  const Clock& clock_;
  std::uint8_t stop_value_ = 0;
  std::uint64_t retries_ = 0;
};

}  // namespace nacelle::range
