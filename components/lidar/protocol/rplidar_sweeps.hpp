// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "lidar/protocol/rotor_offset.hpp"
#include "lidar/protocol/rplidar_decoder.hpp"

namespace nacelle::lidar {

/// Makes sweeps of an RPLIDAR's measurement packets.
///
/// A capsule says where its first point lies only; the next capsule says where its last one did. Therefore a capsule becomes a sweep
/// when the next one has come, and not at all if that was lost. Threads: one. Allocates: nothing.
class RplidarSweeps {
 public:
  /// A new stream begins, whose points are `period` apart.
  void begin(Duration period) {
    period_ = period;
    restart();
  }
  /// Forgets the last packet.
  void restart() {
    has_last_ = false;
    has_sweep_ = false;
    node_step_deg_ = 0.0;
  }
  /// Takes a packet and hands over the sweep that it completes.
  void take(const RplidarPacket& packet, std::size_t bytes_after, SweepSink& sink);
  /// Capsules that became no sweep because the next one was lost, or is too far away.
  [[nodiscard]] std::uint64_t unpaired() const { return unpaired_; }

 private:
  void take_node(const RplidarPacket& packet, std::size_t bytes_after, SweepSink& sink);
  void take_capsule(const RplidarPacket& packet, std::size_t bytes_after, SweepSink& sink);

  Duration period_{};
  std::array<std::uint8_t, rplidar_layout::kMostPacketBytes> last_{};
  bool has_last_ = false;
  bool has_sweep_ = false;
  double last_start_deg_ = 0.0;  ///< Of the last sweep.
  double node_step_deg_ = 0.0;   ///< Smoothed; 0: unknown.
  RotorOffset offset_{0.0};
  std::uint64_t unpaired_ = 0;
  std::array<Beam, rplidar_layout::kMostPoints> beams_{};
};

}  // namespace nacelle::lidar
