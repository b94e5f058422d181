// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "imu/model/sample_assembler.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::imu {

/// Takes samples in their order.
class SampleSink {
 public:
  SampleSink() = default;
  SampleSink(const SampleSink&) = delete;
  SampleSink& operator=(const SampleSink&) = delete;
  virtual ~SampleSink() = default;
  /// `sample.captured` is the latest time at which it can have been measured; `step` is the device's own time since the sample
  /// before, or zero if that is unknown.
  virtual void on_sample(const Sample& sample, Duration step) = 0;
};

/// Turns the bytes of one kind of device into samples.
///
/// Threads: one. Allocates: nothing per sample.
class DeviceReader {
 public:
  /// What came of the bytes, for people.
  struct Counters {
    std::uint64_t bytes{};
    std::uint64_t frames{};  ///< Frames of a line, or blocks of a polled chip.
    std::uint64_t bad_checksums{};
    std::uint64_t skipped_bytes{};
    std::uint64_t samples{};
    std::uint64_t
        incomplete{};  ///< Cycles of which a frame was lost, FIFOs that overflowed, readings of a chip that sleeps.
    std::uint64_t foreign_frames{};
  };

  DeviceReader() = default;
  DeviceReader(const DeviceReader&) = delete;
  DeviceReader& operator=(const DeviceReader&) = delete;
  virtual ~DeviceReader() = default;

  /// `received`: when the last of the bytes was there.
  virtual void feed(ByteView bytes, MonotonicTime received, SampleSink& sink) = 0;
  /// Forgets halves: the line was opened again, or the device set up anew.
  virtual void restart() = 0;
  [[nodiscard]] virtual Counters counters() const = 0;
};

}  // namespace nacelle::imu
