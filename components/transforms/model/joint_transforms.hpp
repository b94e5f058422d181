// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "transforms/model/robot_tree.hpp"

namespace nacelle::transforms {

struct JointTransformsOptions {
  double publish_frequency_hz = 30.0;  ///< At most this often per joint; 0 is never.
  bool ignore_timestamp = false;       ///< Every joint state counts, with any stamp.
};

/// messages == used + mismatched + too_soon + empty.
struct JointTransformsStats {
  std::uint64_t messages{}, used{};
  std::uint64_t mismatched{};      ///< Names and positions differ in number.
  std::uint64_t too_soon{};        ///< No joint of it was due.
  std::uint64_t empty{};           ///< Nothing in it belongs to this robot, or is a number.
  std::uint64_t unknown_joints{};  ///< Names that the description does not know, each time they come.
  std::uint64_t not_finite{};      ///< Positions that are not numbers.
};

/// Turns joint positions into transforms of the movable joints, those that follow another one included.
///
/// robot_state_publisher asks for one period since the joint's last transform, which makes 25 Hz of a limit of 30 and joint
/// states at 50 Hz. Here the due time moves on by periods, so that the mean rate is the limit.
/// Threads:   one. Allocates: in the constructor only.
class JointTransforms {
 public:
  struct Moved {
    std::size_t joint{};  ///< Place in movable().
    RigidTransform X_parent_child;
  };
  JointTransforms(const RobotTree& tree, const JointTransformsOptions& options);

  [[nodiscard]] const std::vector<Joint>& movable() const { return joints_; }
  /// The transforms that are due; valid until the next call.
  [[nodiscard]] std::span<const Moved> update(WallTime stamp, std::span<const std::string> names,
                                              std::span<const double> positions);
  [[nodiscard]] const JointTransformsStats& stats() const { return stats_; }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  struct Follower {
    std::size_t joint{};
    double multiplier{}, offset{};
  };
  struct Leader {
    std::int64_t due_ns{};
    std::int64_t last_ns{};
    bool seen{false};
    std::vector<Follower> followers;  // with the product of their chain
  };
  [[nodiscard]] std::size_t place_of(const std::string& name, std::size_t at);
  [[nodiscard]] bool is_due(Leader& leader, std::int64_t stamp_ns) const;

  std::vector<Joint> joints_;        // movable ones, by name
  std::vector<Leader> leaders_;      // parallel to joints_
  std::vector<std::size_t> places_;  // the joint at each place of the last message
  std::vector<Moved> moved_;
  std::int64_t period_ns_;
  bool ignore_timestamp_;
  JointTransformsStats stats_;
};

}  // namespace nacelle::transforms
