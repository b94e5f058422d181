// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "imu/model/device_reader.hpp"
#include "imu/protocol/wt901_decoder.hpp"

namespace nacelle::imu {

/// Samples of a WT901. Time of a sample: when the first byte of its first frame was put on the line.
class Wt901Reader final : public DeviceReader {
 public:
  Wt901Reader(Wt901Mask mask, double tesla_per_count, Duration byte_time, Duration period)
      : assembler_(mask, tesla_per_count), byte_time_(byte_time), period_(period) {}

  void feed(ByteView bytes, MonotonicTime received, SampleSink& sink) override {
    decoder_.feed(bytes, [&](const Wt901Frame& frame, std::size_t bytes_after) {
      const auto on_line = static_cast<std::int64_t>(bytes_after + wt901_layout::kFrameBytes);
      if (assembler_.add(frame, received - byte_time_ * on_line)) sink.on_sample(assembler_.sample(), period_);
    });
  }
  void restart() override {
    decoder_.restart();
    assembler_.restart();
  }
  [[nodiscard]] Counters counters() const override {
    const auto& line = decoder_.stats();
    const auto& joined = assembler_.stats();
    return {line.bytes,     line.frames,       line.bad_checksums,   line.skipped_bytes,
            joined.samples, joined.incomplete, joined.foreign_frames};
  }

 private:
  Wt901Decoder decoder_;
  SampleAssembler assembler_;
  const Duration byte_time_, period_;
};

}  // namespace nacelle::imu
