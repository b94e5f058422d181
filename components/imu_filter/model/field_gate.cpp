// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/model/field_gate.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::imu_filter {
namespace {

constexpr Duration kLearning = 1s;
constexpr Duration kPause = 1s;  // a longer one ends a run of refused fields

}  // namespace

void FieldGate::Mean::add(WallTime stamp, const FieldShape& seen, bool has_dip) {
  if (count == 0) since = stamp;
  ++count;
  shape.strength_t += (seen.strength_t - shape.strength_t) / static_cast<double>(count);
  if (!has_dip) return;
  ++dips;
  shape.dip_rad += (seen.dip_rad - shape.dip_rad) / static_cast<double>(dips);
}

FieldGate::Verdict FieldGate::compare(const FieldShape& seen, bool has_dip, const FieldShape& with) const {
  const double strength = options_.strength_tolerance_t;
  if (strength > 0.0 && !(std::abs(seen.strength_t - with.strength_t) <= strength)) return Verdict::WrongStrength;
  const double dip = options_.dip_tolerance_rad;
  if (dip > 0.0 && has_dip && !(std::abs(seen.dip_rad - with.dip_rad) <= dip)) return Verdict::WrongDip;
  return Verdict::Fits;
}

// The first second: nothing to compare with yet.
void FieldGate::learn(WallTime stamp, bool has_dip) {
  if (options_.dip_tolerance_rad > 0.0 && !has_dip) return;
  learning_.add(stamp, last_, has_dip);
  if (stamp - learning_.since >= kLearning) reference_ = learning_.shape;
}

FieldGate::Verdict FieldGate::judge(WallTime stamp, const Eigen::Vector3d& field_S_t,
                                    const std::optional<Eigen::Vector3d>& up_S) {
  const double strength = field_S_t.norm();
  const bool has_dip = up_S.has_value();
  const double below = has_dip && strength > 0.0 ? -field_S_t.dot(*up_S) / strength : 0.0;
  last_ = {strength, std::asin(std::clamp(below, -1.0, 1.0))};
  if (!reference_) {
    learn(stamp, has_dip);
    return Verdict::Fits;
  }
  const Verdict verdict = compare(last_, has_dip, *reference_);
  if (verdict == Verdict::Fits) {
    refused_ = {};
    return verdict;
  }
  if (second_ && compare(last_, has_dip, *second_) == Verdict::Fits) return Verdict::Fits;
  const bool goes_on = refused_.count > 0 && stamp >= last_refused_ && stamp - last_refused_ <= kPause &&
                       compare(last_, has_dip && refused_.dips > 0, refused_.shape) == Verdict::Fits;
  if (!goes_on) refused_ = {};
  refused_.add(stamp, last_, has_dip);
  last_refused_ = stamp;
  if (stamp - refused_.since < options_.patience) return verdict;
  second_ = refused_.shape;
  refused_ = {};
  ++adoptions_;
  return Verdict::Fits;
}

}  // namespace nacelle::imu_filter
