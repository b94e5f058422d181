// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lidar/protocol/ld06_decoder.hpp"
#include "lidar/protocol/lidar_protocol.hpp"

namespace nacelle::lidar {

/// Smooth time of an LD06 from its millisecond counter.
///
/// The counter says the time to a millisecond, the number of points to a nanosecond but not how many were lost. Each packet is
/// placed one packet period after the one before, and moved if that is not within the millisecond which the counter says: the
/// result never leaves the device's clock, and does not jump with its digits. Threads: one. Allocates: nothing.
class LdClock {
 public:
  explicit LdClock(unsigned points_per_second)
      : packet_period_(Duration{1'000'000'000LL * static_cast<std::int64_t>(ld06_layout::kPointsPerFrame) /
                                static_cast<std::int64_t>(points_per_second)}) {}

  /// Returns the device's time since the frame before; 0 for the first.
  [[nodiscard]] Duration step(const Ld06Frame& frame);
  void restart() { started_ = false; }

  /// The counter restarts after this value. Source: product page of the LD06.
  static constexpr unsigned kTurnover_ms = 30000;

 private:
  const Duration packet_period_;
  bool started_ = false;
  unsigned last_ms_ = 0, last_angle_cdeg_ = 0;
  Duration within_ms_{};  ///< Of the last frame, after the start of its millisecond.
};

/// LD06, LD19, STL-19P and STL-27L: one packet format at different rates. They send as long as they have power.
class LdProtocol final : public LidarProtocol {
 public:
  explicit LdProtocol(unsigned points_per_second);

  void feed(ByteView bytes, SweepSink& sink) override;
  void restart() override;
  [[nodiscard]] LineStats stats() const override;
  [[nodiscard]] std::size_t pending() const override { return decoder_.pending(); }

 private:
  const Duration period_;
  Ld06Decoder decoder_;
  LdClock clock_;
  std::array<Beam, ld06_layout::kPointsPerFrame> beams_{};
};

}  // namespace nacelle::lidar
