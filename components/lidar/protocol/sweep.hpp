// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "nacelle/base/time.hpp"

namespace nacelle::lidar {

/// One measured direction.
struct Beam {
  float angle_deg{};  ///< Where the light went: clockwise seen from above, 0 at the device's front mark, in [0, 360].
  float range_m{};    ///< 0: nothing came back.
  float intensity{};  ///< Device scale; compare only within one device.
  friend bool operator==(const Beam&, const Beam&) = default;
};

/// Consecutive beams of one packet, in the words that all LiDARs share. The decoders of `protocol/` make it of their packets.
///
/// The rotor turns steadily while a triangulating device corrects the angle of each beam by its range. Therefore the rotor says
/// when a turn ends, and a beam's own angle which ray it belongs to. The rotor's angle is that of a usual beam, so that both agree
/// on when the first ray was measured.
struct Sweep {
  std::span<const Beam> beams;   ///< At least one. Valid during the call that hands it over.
  double first_rotor_deg{};      ///< Rotor angle at the first beam, in [0, 360).
  double rotor_step_deg{};       ///< From beam to beam, not negative. All steps together are less than a turn.
  Duration period{};             ///< From beam to beam.
  Duration since_last{};         ///< Device's own time from the last beam of the sweep before; 0: unknown.
  Duration age{};                ///< How long before the packet was sent the last beam was measured.
  std::size_t packet_bytes = 0;  ///< Length of the packet on the line.
  double speed_dps{};            ///< Of the rotor; 0: unknown.
  bool has_intensities = false;  ///< Does the packet carry intensities?
};

/// Takes what a decoder found.
class SweepSink {
 public:
  SweepSink() = default;
  SweepSink(const SweepSink&) = delete;
  SweepSink& operator=(const SweepSink&) = delete;
  virtual ~SweepSink() = default;

  /// `bytes_after`: bytes of the chunk after the packet's last one, from which the caller computes when the packet ended.
  virtual void on_sweep(const Sweep& sweep, std::size_t bytes_after) = 0;
};

/// What became of the bytes of a line: bytes == framed_bytes + skipped_bytes + those that wait for the rest of their packet.
struct LineStats {
  std::uint64_t bytes{};          ///< Fed so far.
  std::uint64_t frames{};         ///< Measurement packets.
  std::uint64_t framed_bytes{};   ///< In packets with a right checksum: measurements, implausible ones, answers.
  std::uint64_t implausible{};    ///< Whole packets with a right checksum that cannot be true.
  std::uint64_t bad_checksums{};  ///< Packet starts that were rejected; their first byte is in skipped_bytes.
  std::uint64_t skipped_bytes{};
  std::uint64_t unpaired{};  ///< Of the frames, those without beams because the packet after them was lost.
  friend bool operator==(const LineStats&, const LineStats&) = default;
};

}  // namespace nacelle::lidar
