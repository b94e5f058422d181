// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "imu/model/device_reader.hpp"
#include "imu/protocol/block_decoder.hpp"
#include "imu/protocol/chip_decoder.hpp"

namespace nacelle::imu {

/// What the counts of a chip mean.
struct ChipUnits {
  /// Which axis of the magnetometer lies along an axis of the chip, and with which sign.
  struct Axis {
    std::size_t index = 0;
    double sign = 1.0;
  };
  double acceleration_mps2 = 0.0;     ///< Of a count.
  double angular_velocity_rps = 0.0;  ///< Of a count.
  double magnetic_field_t = 0.0;      ///< Of a count; 0: no magnetometer.
  std::array<Axis, 3> field_axes{Axis{0}, Axis{1}, Axis{2}};
  double temperature_k = 0.0;  ///< Of a count; 0: no thermometer.
  double temperature_at_zero_c = 0.0;
  double quaternion = 0.0;  ///< Of a count; 0: none.
  Duration tick{};          ///< Of the chip's clock; 0: it tells no times.
  Duration period{};        ///< Between two readings, by the chip's clock.
};

/// A reading in SI units.
[[nodiscard]] Sample sample_of(const ChipReading& reading, const ChipUnits& units);

/// Samples of a polled chip. The last reading of a poll was measured when it came, those before it one period earlier each, or as
/// the chip's clock says.
class ChipReader final : public DeviceReader, private ReadingSink {
 public:
  ChipReader(std::unique_ptr<ChipDecoder> decoder, const ChipUnits& units);

  void feed(ByteView bytes, MonotonicTime received, SampleSink& sink) override;
  void restart() override;
  [[nodiscard]] Counters counters() const override;

  /// Readings of one poll; more are counted as lost.
  static constexpr std::size_t kMostReadings = 512;

 private:
  void on_reading(const ChipReading& reading) override;
  [[nodiscard]] Duration step_of(const ChipReading& reading) const;

  BlockDecoder blocks_;
  std::unique_ptr<ChipDecoder> decoder_;
  const ChipUnits units_;
  std::vector<ChipReading> polled_;
  std::uint64_t samples_ = 0, lost_ = 0, asleep_ = 0;
  bool is_first_ = true;
};

}  // namespace nacelle::imu
