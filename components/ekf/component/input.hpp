// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist_with_covariance_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include "ekf/component/ekf_options.hpp"
#include "ekf/model/filter.hpp"
#include "nacelle/spatial/transform_buffer.hpp"

namespace nacelle::ekf {

/// What inputs need to know of the rest: the filter they feed and the frames they are expressed in.
struct InputContext {
  Filter* filter{};
  const spatial::TransformBuffer* buffer{};
  const EkfOptions* options{};
  const Clock* clock{};
};

/// One input's messages on their way into the filter, part by part (pose, twist, orientation, ...).
/// Threads: one. Allocates: in the constructor only.
class Input {
 public:
  /// Parts are numbered on from `first_part` in the filter's counters.
  Input(const InputOptions& options, const InputContext& context, std::uint16_t first_part);

  void take(const nav_msgs::msg::Odometry& message);
  void take(const geometry_msgs::msg::PoseWithCovarianceStamped& message);
  void take(const geometry_msgs::msg::TwistWithCovarianceStamped& message);
  void take(const sensor_msgs::msg::Imu& message);
  /// Counts the gap before a message as lost. Call before take(), with the message's MessageInfo. The publishers of one
  /// topic are distinguished. Of more than kMostWriters, gaps are detected only in those with the latest messages.
  void comes_from(std::uint64_t writer, std::uint64_t sequence);
  /// Forgets the reference of differential and relative poses.
  void forget();
  /// Forgets the last pose of a differential input: the motion since then was not looked at.
  void skip_motion() {
    if (options_.differential) memory_ = {};
  }
  /// What is sent while nothing listens is no loss.
  void begin() { heard_ = {}; }

  struct Part {
    std::string name;  ///< "odom0 twist"
    std::uint16_t number{};
    StateMask mask{};
  };
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  [[nodiscard]] const InputOptions& options() const { return options_; }
  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  /// Messages that the subscription's queue dropped.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }
  /// Of the last message; 0 before it.
  [[nodiscard]] std::uint64_t writer() const { return heard_.front().writer; }
  /// Why the last transform was not there.
  [[nodiscard]] const spatial::LookupFault& last_fault() const { return last_fault_; }

  static constexpr std::size_t kMostWriters = 8;

  /// How many parts an input has.
  [[nodiscard]] static std::uint16_t parts_of(const InputOptions& options);

 private:
  struct PoseIn {
    std::string_view frame, child;
    const geometry_msgs::msg::PoseWithCovariance* pose;
  };
  void take_pose(WallTime stamp, const PoseIn& in);
  void take_twist(WallTime stamp, std::string_view frame, const geometry_msgs::msg::TwistWithCovariance& twist);
  [[nodiscard]] Prepared prepare(WallTime stamp, const PoseIn& in, Reading& out);
  struct ChildPose {
    RigidTransform X_MC, X_CB;
    Matrix6d covariance;
  };
  [[nodiscard]] Prepared prepare_as_robot_localization(WallTime stamp, const PoseIn& in, const ChildPose& child,
                                                       Reading& out);
  [[nodiscard]] Prepared prepare_imu_orientation(const sensor_msgs::msg::Imu& message, WallTime stamp, Reading& out);
  [[nodiscard]] Prepared prepare_imu_acceleration(const sensor_msgs::msg::Imu& message, WallTime stamp, Reading& out);
  /// The transform at the time, or the latest if there is none at that time.
  [[nodiscard]] Result<RigidTransform, Rejection> transform(std::string_view target, std::string_view source,
                                                            WallTime stamp);
  [[nodiscard]] std::string_view or_base(const std::string& frame) const {
    return frame.empty() ? std::string_view{context_.options->base_link_frame} : frame;
  }
  [[nodiscard]] PartSetup setup(StateMask mask, double gate) const {
    return {mask, gate, context_.options->filter.two_d_mode, context_.options->robot_localization_rotations};
  }
  [[nodiscard]] const Part* part(StateMask mask) const;
  /// Starts a message: what time it is. Read once for all its parts.
  void begin_message() {
    ++messages_;
    now_ = context_.clock->wall_now();
  }

  InputOptions options_;
  InputContext context_;
  std::vector<Part> parts_;
  PoseMemory memory_;
  WallTime now_{};
  struct Heard {
    std::uint64_t writer{}, sequence{};  // 0: none
  };
  std::array<Heard, kMostWriters> heard_{};  // the last message of each publisher, the latest first
  std::uint64_t messages_{0}, lost_{0};
  spatial::LookupFault last_fault_;
};

}  // namespace nacelle::ekf
