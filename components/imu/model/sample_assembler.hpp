// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "imu/model/wt901_units.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::imu {

/// One measurement of everything, SI units, sensor axes.
struct Sample {
  MonotonicTime captured{};  ///< When the device put the sample's first byte on the line.
  Vector3 acceleration_mps2{};
  Vector3 angular_velocity_rps{};
  bool has_angular_velocity = true;          ///< A BNO08x in mode RVC sends none.
  std::optional<Orientation> orientation{};  ///< ENU; absent if no frame of the mask contains it.
  std::optional<Vector3> magnetic_field_t{};
  std::optional<double> temperature_c{};  ///< Of the die.
};

/// Joins the frames of one device cycle into a sample.
///
/// The device sends the frames of its mask in rising order of type; a sample is complete with the last of them. A cycle
/// with a missing frame is counted and dropped: an old acceleration is never combined with a new angular velocity.
/// Threads: one. Allocates: nothing.
class SampleAssembler {
 public:
  /// Frames of the mask are in one place: frames == (frames of a sample) * samples + given_up_frames + frames under
  /// way.
  struct Stats {
    std::uint64_t frames{};           ///< Of the mask.
    std::uint64_t samples{};          ///< Complete ones.
    std::uint64_t incomplete{};       ///< Cycles that were dropped.
    std::uint64_t given_up_frames{};  ///< Frames in those.
    std::uint64_t foreign_frames{};   ///< Of a type outside the mask; skipped.
  };

  /// Precondition: the mask holds acceleration and angular velocity.
  SampleAssembler(Wt901Mask mask, double tesla_per_count);

  /// Takes a frame whose first byte was sent at `sent`; true when it completes sample().
  bool add(const Wt901Frame& frame, MonotonicTime sent);
  [[nodiscard]] const Sample& sample() const { return sample_; }
  /// Forgets the cycle under way.
  void restart();
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  void give_up();

  const Wt901Mask mask_;
  const double tesla_per_count_;
  Wt901Mask seen_ = 0;
  Sample sample_;
  Stats stats_;
};

}  // namespace nacelle::imu
