// SPDX-License-Identifier: Apache-2.0
#include "odometry/component/odometry_component.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "nacelle/node/frame_name.hpp"
#include "nacelle/qos/presets.hpp"
#include "nacelle/spatial/rotation.hpp"
#include "odometry/component/described_wheels.hpp"

namespace nacelle::odometry {
namespace {

void write_rotation(double yaw_rad, geometry_msgs::msg::Quaternion& out) {
  out.x = 0.0;
  out.y = 0.0;
  out.z = std::sin(0.5 * yaw_rad);
  out.w = std::cos(0.5 * yaw_rad);
}

}  // namespace

OdometryComponent::OdometryComponent(const NodeOptions& options)
    : LifecycleNode("odometry", options), wheels_(shared_object<BaseWheelsList>(kBaseWheelsName, &make_base_wheels)) {
  const DescribedWheels described = read_described_wheels(*this);
  for (const auto& problem : described.problems) declare_problem(problem);
  declare_odometry_parameters(*this, described.defaults);
  odometry_ = create_publisher<nav_msgs::msg::Odometry>("odom", QoS(10));
  transforms_ = create_publisher<tf2_msgs::msg::TFMessage>("/tf", DynamicTransformQoS());
  // Best effort reads from either kind of publisher, as robot_state_publisher does.
  joints_ = create_subscription<sensor_msgs::msg::JointState>(
      "joint_states", SensorDataQoS(QoS(10)),
      [this](const sensor_msgs::msg::JointState& joints) { on_joint_state(joints); });
  reset_ = create_service<std_srvs::srv::Empty>(
      "reset_odom", [this](const std_srvs::srv::Empty::Request&, std_srvs::srv::Empty::Response&) { reset_pose(); });
  if (get<bool>("enable_odom_tf")) {
    // By default it yields to a filter; an explicit `true` beside a filter makes two owners, which is an error.
    claim_ = claim_frame(frame_name(*this, "odom_frame_id"), frame_name(*this, "base_frame_id"),
                         is_given("enable_odom_tf") ? FrameClaimKind::Primary : FrameClaimKind::Fallback,
                         Place::of_parameter("enable_odom_tf"));
  }
  declare_frame_use(frame_name(*this, "odom_frame_id"), "odom_frame_id");
  declare_frame_use(frame_name(*this, "base_frame_id"), "base_frame_id");
  if (const auto read = read_odometry_parameters(*this); !read) declare_problem(read.error());
}

CallbackReturn OdometryComponent::on_configure(const State&) {
  auto options = read_odometry_parameters(*this);
  if (!options) {
    Problem problem = options.error();
    problem.where.node = get_fully_qualified_name();
    return refuse(problem);
  }
  options_ = std::move(options).value();
  take_wheels_of_base();
  reader_.emplace(JointReaderOptions{options_.left_wheel_names, options_.right_wheel_names, options_.left_radius_m(),
                                     options_.right_radius_m(), options_.max_wheel_speed_rps,
                                     options_.position_range_rad});
  velocity_.emplace(static_cast<std::size_t>(options_.velocity_rolling_window_size));
  reset_pose();
  told_owner_ = false;
  told_jumps_ = 0;
  told_incomplete_ = false;
  return CallbackReturn::SUCCESS;
}

std::optional<BaseWheels> OdometryComponent::find_base() const {
  auto list = wheels_->lock();
  std::vector<BaseWheels> bases;
  std::ranges::copy_if(*list, std::back_inserter(bases),
                       [this](const BaseWheels& base) { return base.name_space == get_namespace(); });
  const auto same = std::ranges::find_if(bases, [this](const BaseWheels& base) {
    return base.left_joints == options_.left_wheel_names && base.right_joints == options_.right_wheel_names;
  });
  if (same != bases.end()) return *same;
  const OdometryOptions untold;
  const bool names_are_told = is_given("left_wheel_names") || is_given("right_wheel_names") ||
                              options_.left_wheel_names != untold.left_wheel_names ||
                              options_.right_wheel_names != untold.right_wheel_names;
  if (names_are_told || bases.size() != 1) return std::nullopt;
  return bases.front();
}

void OdometryComponent::take_wheels_of_base() {
  const auto base = find_base();
  if (!base) return;
  options_.left_wheel_names = base->left_joints;
  options_.right_wheel_names = base->right_joints;
  // A length of the base comes with the base's multiplier, unless the odometry has a multiplier of its own.
  const bool separation = !is_given("wheel_separation"), radius = !is_given("wheel_radius");
  if (separation) {
    options_.wheel_separation_m = base->separation_m;
    if (!is_given("wheel_separation_multiplier")) options_.wheel_separation_multiplier = base->separation_multiplier;
  }
  if (radius) {
    options_.wheel_radius_m = base->radius_m;
    if (!is_given("left_wheel_radius_multiplier")) options_.left_wheel_radius_multiplier = base->left_radius_multiplier;
    if (!is_given("right_wheel_radius_multiplier"))
      options_.right_wheel_radius_multiplier = base->right_radius_multiplier;
  }
  if (!separation && !radius) return;
  get_logger().info("{} of {}: {} m apart, radii {} and {} m",
                    separation && radius ? "the wheels are those"
                    : separation         ? "the wheels' separation is that"
                                         : "the wheels' radius is that",
                    base->node, options_.separation_m(), options_.left_radius_m(), options_.right_radius_m());
}

bool OdometryComponent::is_given(const char* parameter) const { return parameters().overrides().count(parameter) != 0; }

CallbackReturn OdometryComponent::on_activate(const State&) {
  // What happened while inactive was not seen: the next sample starts the differences.
  reader_->restart();
  velocity_->clear();
  return CallbackReturn::SUCCESS;
}

CallbackReturn OdometryComponent::on_cleanup(const State&) {
  reader_.reset();
  velocity_.reset();
  return CallbackReturn::SUCCESS;
}

void OdometryComponent::reset_pose() {
  pose_ = {};
  pose_.covariance.diagonal() << options_.pose_covariance_diagonal[0], options_.pose_covariance_diagonal[1],
      options_.pose_covariance_diagonal[5];
}

void OdometryComponent::on_joint_state(const sensor_msgs::msg::JointState& joints) {
  const auto step =
      reader_->read(time_of(joints.header.stamp), {joints.name.data(), joints.name.size()},
                    {joints.position.data(), joints.position.size()}, {joints.velocity.data(), joints.velocity.size()});
  if (!step) {
    if (reader_->stats().jumps != told_jumps_) tell_jumps();
    if (reader_->stats().incomplete != 0 && !told_incomplete_) tell_incomplete(joints);
    return;
  }
  pose_ = options_.noise ? integrate(pose_, step->wheels, options_.separation_m(), *options_.noise)
                         : integrate_with_slip(pose_, step->wheels, options_.separation_m(), options_.slip);
  publish_odometry(joints, step->wheels, step->dt_s);
  if (claim_) publish_transform(joints);
}

void OdometryComponent::publish_odometry(const sensor_msgs::msg::JointState& joints, const WheelStep& step,
                                         double dt_s) {
  const double distance_m = 0.5 * (step.left_m + step.right_m);
  const double turn_rad = (step.right_m - step.left_m) / options_.separation_m();
  velocity_->add(distance_m, turn_rad, dt_s);
  auto message = odometry_->borrow();
  if (!message) return;
  message->header.stamp = joints.header.stamp;
  message->header.frame_id = options_.odom_frame_id;
  message->child_frame_id = options_.base_frame_id;
  message->pose.pose.position.x = pose_.x_m;
  message->pose.pose.position.y = pose_.y_m;
  message->pose.pose.position.z = 0.0;
  write_rotation(pose_.yaw_rad, message->pose.pose.orientation);
  auto& pose_covariance = message->pose.covariance;
  pose_covariance.fill(0.0);
  for (std::size_t i = 0; i < 6; ++i) pose_covariance[i * 7] = options_.pose_covariance_diagonal[i];
  constexpr std::size_t kRows[3] = {0, 1, 5};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      pose_covariance[kRows[i] * 6 + kRows[j]] = pose_.covariance(static_cast<int>(i), static_cast<int>(j));
    }
  }

  const double speed_mps = velocity_->speed_mps();
  const double yaw_rate_rps = velocity_->yaw_rate_rps();
  auto& twist = message->twist.twist;
  twist.linear.x = speed_mps;
  twist.linear.y = twist.linear.z = twist.angular.x = twist.angular.y = 0.0;
  twist.angular.z = yaw_rate_rps;
  // The same noise as the pose's: the variance of the distance in the window, divided by the square of its duration.
  const double half_m = 0.5 * options_.separation_m() * yaw_rate_rps;
  const double window_s = velocity_->duration_s();
  const StepVariance variance =
      options_.variance_of({(speed_mps - half_m) * window_s, (speed_mps + half_m) * window_s});
  const double per_square = window_s > 0.0 ? 1.0 / (window_s * window_s) : 0.0;
  auto& twist_covariance = message->twist.covariance;
  twist_covariance.fill(0.0);
  for (std::size_t i = 0; i < 6; ++i) twist_covariance[i * 7] = options_.twist_covariance_diagonal[i];
  twist_covariance[0] += variance.along * per_square;
  twist_covariance[7] += variance.across * per_square;
  twist_covariance[35] += variance.turn * per_square;
  twist_covariance[5] = twist_covariance[30] = variance.along_turn * per_square;
  odometry_->publish(std::move(message));
}

void OdometryComponent::publish_transform(const sensor_msgs::msg::JointState& joints) {
  if (!claim_->is_owner()) {
    if (!told_owner_) {
      told_owner_ = true;
      get_logger().info("{} -> {} is broadcast by {}; this node leaves it to that one", options_.odom_frame_id,
                        options_.base_frame_id, claim_->owner());
    }
    return;
  }
  told_owner_ = false;
  auto message = transforms_->borrow();
  if (!message) return;
  message->transforms.resize(1);
  auto& transform = message->transforms[0];
  transform.header.stamp = joints.header.stamp;
  transform.header.frame_id = options_.odom_frame_id;
  transform.child_frame_id = options_.base_frame_id;
  transform.transform.translation.x = pose_.x_m;
  transform.transform.translation.y = pose_.y_m;
  transform.transform.translation.z = 0.0;
  write_rotation(pose_.yaw_rad, transform.transform.rotation);
  transforms_->publish(std::move(message));
}

void OdometryComponent::tell_jumps() {
  told_jumps_ = reader_->stats().jumps;
  // Every power of two, so that a board that restarts all day does not fill the log.
  if ((told_jumps_ & (told_jumps_ - 1)) == 0) {
    get_logger().warn(
        "a wheel position jumped (now {} times): the board was restarted, or counts in a circle that position_range "
        "does "
        "not say; the pose goes on from where it was",
        told_jumps_);
  }
  velocity_->clear();
}

void OdometryComponent::tell_incomplete(const sensor_msgs::msg::JointState& joints) {
  told_incomplete_ = true;
  std::string missing;
  for (const auto* const names : {&options_.left_wheel_names, &options_.right_wheel_names}) {
    for (const auto& name : *names) {
      if (missing.empty() && std::ranges::find(joints.name, name) == joints.name.end()) missing = name;
    }
  }
  if (!missing.empty()) {
    get_logger().warn("a message on {} does not have the joint '{}': without it there is no odometry",
                      joints_->get_topic_name(), missing);
  } else {
    get_logger().warn(
        "a message on {} has {} names, {} positions and {} velocities: without as many of one of them as names "
        "there is no odometry",
        joints_->get_topic_name(), joints.name.size(), joints.position.size(), joints.velocity.size());
  }
}

}  // namespace nacelle::odometry
