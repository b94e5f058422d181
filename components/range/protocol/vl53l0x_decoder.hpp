// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::range {

/// How a measurement of a VL53L0X ended: the four bits that the maker's interface calls the device's error.
/// Source: ST, VL53L0X API (STSW-IMG005), vl53l0x_device.h, VL53L0X_DeviceError.
enum class Vl53l0xStatus : std::uint8_t {
  None = 0,
  LaserContinuity = 1,  ///< 1 to 3: the laser or its supply does not work.
  LaserWatchdog = 2,
  NoHighVoltage = 3,
  NoTarget = 4,  ///< Too little light came back.
  Noise = 5,
  Phase = 6,  ///< 6, 9: the phase does not fit: the target is farther than the phase can tell.
  Sigma = 7,
  TargetCheck = 8,
  PhaseConsistency = 9,
  BelowMinimum = 10,
  Complete = 11,  ///< The distance is valid.
  Underflow = 12,
  Overflow = 13,
  Ignored = 14,
  Reserved = 15
};

/// A result of the device, in its units.
struct Vl53l0xResult {
  Vl53l0xStatus status = Vl53l0xStatus::None;
  std::uint16_t distance_mm = 0;   ///< 8190 and 8191 where there is none.
  std::uint16_t signal_rate = 0;   ///< 1/128 million photons a second.
  std::uint16_t ambient_rate = 0;  ///< 1/128 million photons a second, of other light.
  std::uint16_t spads_in_256 = 0;  ///< How many of the detector's cells were in use, times 256.
  [[nodiscard]] bool operator==(const Vl53l0xResult&) const = default;
};

/// Results from the registers 14 to 1F, as they are read one after the other.
///
///     offset  bytes  field
///          0      1  status        bits 6..3
///          2      2  cells         big-endian, as all
///          6      2  signal rate
///          8      2  ambient rate
///         10      2  distance, mm
///
/// Source: ST, VL53L0X API, VL53L0X_GetRangingMeasurementData.
/// Threads: one. Allocates: nothing.
class Vl53l0xDecoder {
 public:
  static constexpr std::size_t kRecordBytes = 12;
  /// Every byte is in one place: bytes == 12 * results + dropped + pending().
  struct Stats {
    std::uint64_t bytes{}, results{}, dropped{};
  };

  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_result) {
    for (const std::uint8_t byte : bytes) {
      ++stats_.bytes;
      record_[filled_++] = byte;
      if (filled_ < kRecordBytes) continue;
      filled_ = 0;
      ++stats_.results;
      on_result(decode(record_));
    }
  }
  /// What comes next does not continue the last bytes.
  void restart() {
    stats_.dropped += filled_;
    filled_ = 0;
  }
  [[nodiscard]] std::size_t pending() const { return filled_; }
  [[nodiscard]] const Stats& stats() const { return stats_; }

  [[nodiscard]] static Vl53l0xResult decode(const std::array<std::uint8_t, kRecordBytes>& record);

 private:
  std::array<std::uint8_t, kRecordBytes> record_{};
  std::size_t filled_ = 0;
  Stats stats_;
};

/// The distance as REP 117 asks: +Inf if there is nothing within `most_m`, -Inf if something is nearer than `least_m`, NaN if the device
/// measured nothing that means anything (its laser fails, the noise is too high).
/// Units: m.
[[nodiscard]] double range_of(const Vl53l0xResult& result, double least_m, double most_m);

}  // namespace nacelle::range
