// SPDX-License-Identifier: Apache-2.0
#include "imu/model/rvc_reader.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::imu {

Sample sample_of(const RvcFrame& frame) {
  constexpr double kRadPerCount = 0.01 * std::numbers::pi / 180.0;
  Sample sample;
  sample.has_angular_velocity = false;
  for (std::size_t i = 0; i < 3; ++i) sample.acceleration_mps2[i] = frame.acceleration_mg[i] * 1e-3 * kGravityMps2;
  const double yaw = 0.5 * kRadPerCount * frame.angles_cdeg[0], pitch = 0.5 * kRadPerCount * frame.angles_cdeg[1];
  const double roll = 0.5 * kRadPerCount * frame.angles_cdeg[2];
  const double cr = std::cos(roll), sr = std::sin(roll), cp = std::cos(pitch), sp = std::sin(pitch);
  const double cy = std::cos(yaw), sy = std::sin(yaw);
  sample.orientation = Orientation{cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr,
                                   cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr};
  return sample;
}

void RvcReader::feed(ByteView bytes, MonotonicTime received, SampleSink& sink) {
  decoder_.feed(bytes, [&](const RvcFrame& frame, std::size_t bytes_after) {
    Sample sample = sample_of(frame);
    sample.captured = received - byte_time_ * static_cast<std::int64_t>(bytes_after + rvc_layout::kFrameBytes);
    Duration step{};
    if (last_index_) {
      // A repeated index is a whole turn of the counter.
      const auto frames = static_cast<std::uint8_t>(frame.index - *last_index_ - 1) + 1;
      lost_ += static_cast<std::uint64_t>(frames - 1);
      step = frames * kPeriod;
    }
    last_index_ = frame.index;
    sink.on_sample(sample, step);
  });
}

void RvcReader::restart() {
  decoder_.restart();
  last_index_.reset();
}

DeviceReader::Counters RvcReader::counters() const {
  const auto& line = decoder_.stats();
  return {line.bytes, line.frames, line.bad_checksums, line.skipped_bytes, line.frames, lost_, 0};
}

}  // namespace nacelle::imu
