// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

// The bytes of an RPLIDAR, from the device's side on purpose: the driver's decoder is another reading of the same description.
// Source: Slamtec/rplidar_sdk (rplidar_cmd.h, sl_lidar_protocol.h, commit a7d0233) and the maker's protocol description LR001.

/// Splits the host's bytes into requests.
class RplidarRequests {
 public:
  struct Stats {
    std::uint64_t requests{}, bad_checksums{}, skipped_bytes{};
  };
  /// Calls `on_request(command, payload)` for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_request) {
    for (const std::uint8_t byte : bytes) {
      waiting_.push_back(byte);
      if (waiting_[0] != 0xA5) {
        waiting_.clear();
        ++stats_.skipped_bytes;
        continue;
      }
      if (waiting_.size() < 2) continue;
      const bool has_payload = (waiting_[1] & 0x80U) != 0;
      if (has_payload && (waiting_.size() < 3 || waiting_.size() < 4U + waiting_[2])) continue;
      std::uint8_t sum = 0;
      for (const std::uint8_t each : waiting_) sum = static_cast<std::uint8_t>(sum ^ each);
      const Bytes request = std::exchange(waiting_, {});
      if (has_payload && sum != 0) {
        ++stats_.bad_checksums;
        continue;
      }
      ++stats_.requests;
      on_request(request[1], has_payload ? ByteView{request}.subspan(3, request[2]) : ByteView{});
    }
  }
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  Bytes waiting_;
  Stats stats_;
};

/// What a point is before it is packed. Angles of the rotor are clockwise.
struct RplidarPoint {
  double rotor_deg{};
  double offset_deg{};  ///< The light went to rotor_deg - offset_deg.
  double range_mm{};    ///< 0: nothing came back.
};

/// The announcement of an answer.
[[nodiscard]] Bytes print_rplidar_descriptor(std::uint32_t length, bool endless, std::uint8_t type);
/// A node of the standard scan. `quality`: 0 to 63.
[[nodiscard]] std::array<std::uint8_t, 5> print_rplidar_node(const RplidarPoint& point, bool starts_turn,
                                                             unsigned quality);
/// A capsule of 32 points, type 82. `first`: the first one after the start of the scan.
[[nodiscard]] Bytes print_rplidar_capsule(std::span<const RplidarPoint> points, bool first);
/// A dense capsule of 40 points, type 85.
[[nodiscard]] Bytes print_rplidar_dense_capsule(std::span<const RplidarPoint> points, bool first);
/// An ultra capsule of 96 points, type 84; `next` is the point after the last.
[[nodiscard]] Bytes print_rplidar_ultra_capsule(std::span<const RplidarPoint> points, const RplidarPoint& next,
                                                bool first);
/// How far past its axis a triangulating RPLIDAR looks, in the ultra capsules' rule.
[[nodiscard]] double rplidar_offset_deg(double range_mm);

}  // namespace nacelle::simulation
