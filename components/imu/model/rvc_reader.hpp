// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "imu/model/device_reader.hpp"
#include "imu/protocol/rvc_decoder.hpp"

namespace nacelle::imu {

/// Acceleration and orientation of a BNO08x frame: R = Rz(yaw) Ry(pitch) Rx(roll), in SI units.
[[nodiscard]] Sample sample_of(const RvcFrame& frame);

/// Samples of a BNO08x in mode UART-RVC. The frames' index is the device's clock: 10 ms each. Time of a sample: when the first byte of
/// its frame was put on the line.
class RvcReader final : public DeviceReader {
 public:
  explicit RvcReader(Duration byte_time) : byte_time_(byte_time) {}

  void feed(ByteView bytes, MonotonicTime received, SampleSink& sink) override;
  void restart() override;
  [[nodiscard]] Counters counters() const override;

  static constexpr Duration kPeriod = 10ms;

 private:
  RvcDecoder decoder_;
  const Duration byte_time_;
  std::optional<std::uint8_t> last_index_{};
  std::uint64_t lost_ = 0;
};

}  // namespace nacelle::imu
