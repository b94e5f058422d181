// SPDX-License-Identifier: Apache-2.0
#include "transforms/model/joint_transforms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nacelle::transforms {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t kPlaces = 256;  // of a message that are remembered; a longer one is searched by name

}  // namespace

JointTransforms::JointTransforms(const RobotTree& tree, const JointTransformsOptions& options)
    : places_(kPlaces, kNone),
      period_ns_(options.publish_frequency_hz > 0.0 ? static_cast<std::int64_t>(1e9 / options.publish_frequency_hz)
                                                    : kNever),
      ignore_timestamp_(options.ignore_timestamp) {
  for (const Joint& joint : tree.joints) {
    if (joint.kind != JointKind::Fixed) joints_.push_back(joint);
  }
  std::sort(joints_.begin(), joints_.end(), [](const Joint& a, const Joint& b) { return a.name < b.name; });
  leaders_.resize(joints_.size());
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    // Follow the chain to the joint that moves by itself. read_urdf() ensures that there is one.
    double multiplier = 1.0, offset = 0.0;
    std::size_t at = i;
    for (std::size_t hops = 0; joints_[at].mimic && hops <= joints_.size(); ++hops) {
      const Mimic& mimic = *joints_[at].mimic;
      offset += multiplier * mimic.offset;
      multiplier *= mimic.multiplier;
      at = place_of(mimic.joint, kPlaces);
    }
    if (at != i) leaders_[at].followers.push_back({i, multiplier, offset});
  }
  moved_.reserve(joints_.size());
}

std::size_t JointTransforms::place_of(const std::string& name, std::size_t at) {
  if (at < kPlaces && places_[at] != kNone && joints_[places_[at]].name == name) return places_[at];
  const auto found = std::lower_bound(joints_.begin(), joints_.end(), name,
                                      [](const Joint& a, const std::string& b) { return a.name < b; });
  if (found == joints_.end() || found->name != name) return kNone;
  const auto place = static_cast<std::size_t>(found - joints_.begin());
  if (at < kPlaces) places_[at] = place;
  return place;
}

bool JointTransforms::is_due(Leader& leader, std::int64_t stamp_ns) const {
  if (ignore_timestamp_) return true;
  if (period_ns_ == kNever) return false;
  const bool went_back = leader.seen && stamp_ns < leader.last_ns;  // the clock was set: begin again
  if (leader.seen && !went_back && stamp_ns < leader.due_ns) return false;
  // On the old beat if that is near, else a new one: no burst after a silence.
  const bool on_beat = leader.seen && !went_back && stamp_ns - leader.due_ns < period_ns_;
  leader.due_ns = (on_beat ? leader.due_ns : stamp_ns) + period_ns_;
  leader.last_ns = stamp_ns;
  leader.seen = true;
  return true;
}

std::span<const JointTransforms::Moved> JointTransforms::update(WallTime stamp, std::span<const std::string> names,
                                                                std::span<const double> positions) {
  moved_.clear();
  ++stats_.messages;
  if (names.size() != positions.size()) {
    ++stats_.mismatched;
    return {};
  }
  bool any = false;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t joint = place_of(names[i], i);
    if (joint == kNone) {
      ++stats_.unknown_joints;
      continue;
    }
    if (!std::isfinite(positions[i])) {
      ++stats_.not_finite;
      continue;
    }
    if (joints_[joint].mimic) continue;  // it follows its leader; its own state is ignored
    any = true;
    // Of a joint that is twice in one message, the first state counts.
    if (moved_.size() == moved_.capacity() || !is_due(leaders_[joint], stamp.nanoseconds())) continue;
    moved_.push_back({joint, joints_[joint].at(positions[i])});
    for (const Follower& follower : leaders_[joint].followers) {
      if (moved_.size() == moved_.capacity()) break;
      moved_.push_back(
          {follower.joint, joints_[follower.joint].at(follower.multiplier * positions[i] + follower.offset)});
    }
  }
  if (!moved_.empty()) {
    ++stats_.used;
  } else {
    ++(any ? stats_.too_soon : stats_.empty);
  }
  return moved_;
}

}  // namespace nacelle::transforms
