// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include "nacelle/base/time.hpp"
#include "navsat/model/fix_check.hpp"
#include "navsat/model/world_alignment.hpp"

namespace nacelle::navsat {

/// What became of the messages of one input: received == used + the refused ones.
struct InputCounters {
  std::uint64_t received{}, used{};
  Refusals refused{};
  [[nodiscard]] std::uint64_t of(Refusal cause) const { return refused[static_cast<std::size_t>(cause)]; }
};

struct NavsatStats {
  InputCounters fixes, odometry, imu;
  std::uint64_t published{};           ///< On odometry/gps.
  std::uint64_t overtaken{};           ///< Fixes that a newer one replaced before the next output.
  std::uint64_t unknown_covariance{};  ///< Fixes that got the covariance of stddev_if_unknown.
  std::uint64_t other_zone{};          ///< Fixes of another zone of UTM than the datum's, given in the datum's.
  std::uint64_t without_antenna{};     ///< Published without the antenna's place on the base, which tf does not know.
};

struct HeldFix {
  CheckedFix value{};
  WallTime stamp{};
  std::string frame;
};

struct HeldPose {
  RigidTransform X_WB{};
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();
  WallTime stamp{};
  std::string world_frame, base_frame;
};

struct HeldHeading {
  Eigen::Quaterniond R_ES = Eigen::Quaterniond::Identity();  ///< Of the sensor, without correction.
  std::string frame;
};

/// The newest usable message of each input.
///
/// Threads: the component's executor. Allocates: nothing, once it has met the frames' names.
class NavsatInputs {
 public:
  using Taken = Result<void, Refusal>;

  explicit NavsatInputs(const FixRules& rules) : rules_(rules) {}

  Taken take(const sensor_msgs::msg::NavSatFix& message);
  Taken take(const nav_msgs::msg::Odometry& message);
  Taken take(const sensor_msgs::msg::Imu& message);

  [[nodiscard]] const std::optional<HeldFix>& fix() const { return fix_; }
  [[nodiscard]] const std::optional<HeldPose>& pose() const { return pose_; }
  [[nodiscard]] const std::optional<HeldHeading>& heading() const { return heading_; }
  /// Whether they are newer than the last call of use_fix() and use_pose().
  [[nodiscard]] bool has_new_fix() const { return fix_is_new_; }
  [[nodiscard]] bool has_new_pose() const { return pose_is_new_; }
  void use_fix() { fix_is_new_ = false; }
  void use_pose() { pose_is_new_ = false; }
  /// Forgets the fix: the world's frame is aligned with a later one.
  void forget_fix() {
    fix_.reset();
    fix_is_new_ = false;
  }
  /// The projection does not reach the newest fix.
  void refuse_fix(Refusal cause);

  NavsatStats stats{};

 private:
  static Taken refuse(InputCounters& counters, Refusal cause);

  FixRules rules_;
  std::optional<HeldFix> fix_;
  std::optional<HeldPose> pose_;
  std::optional<HeldHeading> heading_;
  bool fix_is_new_ = false, pose_is_new_ = false;
};

/// Reads a matrix of a message row by row.
template <int Size, std::size_t Count>
[[nodiscard]] Eigen::Matrix<double, Size, Size> square_of(const std::array<double, Count>& numbers) {
  static_assert(Count == std::size_t{Size} * Size);
  return Eigen::Map<const Eigen::Matrix<double, Size, Size, Eigen::RowMajor>>(numbers.data());
}

}  // namespace nacelle::navsat
