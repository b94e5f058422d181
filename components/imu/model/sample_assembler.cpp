// SPDX-License-Identifier: Apache-2.0
#include "imu/model/sample_assembler.hpp"

#include <bit>

#include "nacelle/base/expect.hpp"

namespace nacelle::imu {

SampleAssembler::SampleAssembler(Wt901Mask mask, double tesla_per_count)
    : mask_(mask), tesla_per_count_(tesla_per_count) {
  constexpr Wt901Mask kNeeded = mask_bit(Wt901Type::Acceleration) | mask_bit(Wt901Type::AngularVelocity);
  NACELLE_EXPECT((mask & kNeeded) == kNeeded, "a sample needs acceleration and angular velocity");
}

void SampleAssembler::give_up() {
  if (seen_ == 0) return;
  ++stats_.incomplete;
  stats_.given_up_frames += static_cast<std::uint64_t>(std::popcount(seen_));
  seen_ = 0;
}

void SampleAssembler::restart() { give_up(); }

bool SampleAssembler::add(const Wt901Frame& frame, MonotonicTime sent) {
  const auto bit = static_cast<Wt901Mask>(1U << (frame.type & 0x0FU));
  if ((mask_ & bit) == 0) {
    ++stats_.foreign_frames;
    return false;
  }
  ++stats_.frames;
  // A type that is not above the last one begins a new cycle.
  if (seen_ >= bit) give_up();
  if (seen_ == 0) {
    sample_ = Sample{};
    sample_.captured = sent;
  }
  seen_ = static_cast<Wt901Mask>(seen_ | bit);
  if (frame.is(Wt901Type::Acceleration)) {
    sample_.acceleration_mps2 = acceleration_mps2(frame);
    sample_.temperature_c = 0.01 * frame.values[3];
  }
  if (frame.is(Wt901Type::AngularVelocity)) sample_.angular_velocity_rps = angular_velocity_rps(frame);
  if (frame.is(Wt901Type::MagneticField)) sample_.magnetic_field_t = magnetic_field_t(frame, tesla_per_count_);
  if (frame.is(Wt901Type::Angles)) sample_.orientation = orientation_from_angles(frame);
  if (frame.is(Wt901Type::Quaternion)) {
    // Finer than the angles, and without their singularity; the angles stay if it is not one yet.
    if (const auto orientation = orientation_from_quaternion(frame)) sample_.orientation = orientation;
  }
  const bool last = bit > (mask_ & ~bit);
  if (!last) return false;
  if (seen_ != mask_) {
    give_up();
    return false;
  }
  seen_ = 0;
  ++stats_.samples;
  return true;
}

}  // namespace nacelle::imu
