// SPDX-License-Identifier: Apache-2.0
#include "transforms/component/transforms_component.hpp"

#include "nacelle/qos/presets.hpp"

namespace nacelle::transforms {
namespace {

using geometry_msgs::msg::TransformStamped;

void write(const RigidTransform& X, geometry_msgs::msg::Transform& out) {
  out.translation.x = X.translation_m.x();
  out.translation.y = X.translation_m.y();
  out.translation.z = X.translation_m.z();
  out.rotation.x = X.rotation.x();
  out.rotation.y = X.rotation.y();
  out.rotation.z = X.rotation.z();
  out.rotation.w = X.rotation.w();
}
RigidTransform read(const geometry_msgs::msg::Transform& from) {
  return {Eigen::Quaterniond{from.rotation.w, from.rotation.x, from.rotation.y, from.rotation.z},
          Eigen::Vector3d{from.translation.x, from.translation.y, from.translation.z}};
}

// Smaller steps than this are slewing, or two readings of a clock that do not happen at once.
constexpr Duration kClockStep = 100ms;

bool is_power_of_two(std::uint64_t n) { return (n & (n - 1)) == 0; }

}  // namespace

TransformsComponent::TransformsComponent(const NodeOptions& options) : LifecycleNode("transforms", options) {
  declare_transforms_parameters(*this);
  buffer_ =
      shared_object<spatial::TransformBuffer>(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer);
  skews_ = shared_object<ClockSkews>(kClockSkewsName, &make_clock_skews);
  buffer_->explain_by(skews_);
  description_ = create_publisher<std_msgs::msg::String>("robot_description", QoS(1).transient_local());
  moving_ = create_publisher<tf2_msgs::msg::TFMessage>("/tf", DynamicTransformQoS());
  fixed_ = create_publisher<tf2_msgs::msg::TFMessage>("/tf_static", StaticTransformQoS());
  joint_states_ = create_subscription<sensor_msgs::msg::JointState>(
      "joint_states", SensorDataQoS(), [this](const sensor_msgs::msg::JointState& state) { on_joint_state(state); });
  heard_moving_ = create_subscription<tf2_msgs::msg::TFMessage>(
      "/tf", DynamicTransformQoS(), [this](const tf2_msgs::msg::TFMessage& message, const MessageInfo& info) {
        on_transforms(message, spatial::Permanence::Dynamic, info.writer_id);
      });
  heard_fixed_ = create_subscription<tf2_msgs::msg::TFMessage>(
      "/tf_static", StaticTransformListenerQoS(),
      [this](const tf2_msgs::msg::TFMessage& message, const MessageInfo& info) {
        on_transforms(message, spatial::Permanence::Static, info.writer_id);
      });
  claim_frames();
}

// Called in the constructor, so that two owners of a frame are found before anything moves. Faults of the description are reported
// when the node is configured.
void TransformsComponent::claim_frames() {
  const auto options = read_transforms_parameters(*this);
  if (!options) return declare_problem(options.error());
  for (const Joint& joint : options->tree.joints) {
    const auto kind = joint.kind == JointKind::Fixed ? FrameClaimKind::Fixed : FrameClaimKind::Primary;
    claims_.push_back(
        claim_frame(joint.parent, joint.child, kind, "the joint '" + joint.name + "' of the robot description"));
  }
  for (const StaticTransform& transform : options->static_transforms) {
    claims_.push_back(claim_frame(transform.parent, transform.child, FrameClaimKind::Fixed,
                                  Place::of_parameter("static_transforms")));
  }
}

CallbackReturn TransformsComponent::on_configure(const State&) {
  auto options = read_transforms_parameters(*this);
  if (!options) {
    Problem problem = options.error();
    problem.where.node = get_fully_qualified_name();
    return refuse(problem);
  }
  options_ = std::move(options).value();
  joints_.emplace(options_->tree, options_->joints);
  told_mismatched_ = told_unknown_ = 0;
  if (!options_->tree.left_out.empty()) {
    get_logger().warn("floating and planar joints have no transform of their own here: {}",
                      join(options_->tree.left_out));
  }
  return CallbackReturn::SUCCESS;
}

CallbackReturn TransformsComponent::on_activate(const State&) {
  publish_fixed();
  if (!options_->description.empty()) {
    auto message = description_->borrow();
    if (message) {
      message->data = options_->description;
      description_->publish(std::move(message));
    }
  }
  return CallbackReturn::SUCCESS;
}

CallbackReturn TransformsComponent::on_cleanup(const State&) {
  options_.reset();
  joints_.reset();
  return CallbackReturn::SUCCESS;
}

void TransformsComponent::publish_fixed() {
  auto message = fixed_->borrow();
  if (!message) return;
  message->transforms.clear();
  const builtin_interfaces::msg::Time stamp = now();
  const auto add = [&](const std::string& parent, const std::string& child, const RigidTransform& X_PC) {
    TransformStamped& transform = message->transforms.emplace_back();
    transform.header.stamp = stamp;
    transform.header.frame_id = parent;
    transform.child_frame_id = child;
    write(X_PC, transform.transform);
  };
  for (const Joint& joint : options_->tree.joints) {
    if (joint.kind == JointKind::Fixed) add(joint.parent, joint.child, joint.origin);
  }
  for (const StaticTransform& transform : options_->static_transforms)
    add(transform.parent, transform.child, transform.X_PC);
  // Readers of this process need not wait for the message to come round.
  on_transforms(*message, spatial::Permanence::Static, 0);
  fixed_->publish(std::move(message));
}

void TransformsComponent::on_joint_state(const sensor_msgs::msg::JointState& state) {
  const auto moved = joints_->update(time_of(state.header.stamp), {state.name.data(), state.name.size()},
                                     {state.position.data(), state.position.size()});
  if (joints_->stats().mismatched != told_mismatched_ || joints_->stats().unknown_joints != told_unknown_)
    tell_trouble();
  if (moved.empty()) return;
  auto message = moving_->borrow();
  if (!message) return;
  message->transforms.resize(moved.size());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Joint& joint = joints_->movable()[moved[i].joint];
    TransformStamped& transform = message->transforms[i];
    transform.header.stamp = state.header.stamp;
    transform.header.frame_id = joint.parent;
    transform.child_frame_id = joint.child;
    write(moved[i].X_parent_child, transform.transform);
  }
  moving_->publish(std::move(message));
}

void TransformsComponent::on_transforms(const tf2_msgs::msg::TFMessage& message, spatial::Permanence permanence,
                                        std::uint64_t writer) {
  // Samples from before the clock was set back would lie in the future of all that follow.
  const Duration offset = now().since_origin - steady_clock().now().since_origin;
  if (clock_offset_ && offset < *clock_offset_ - kClockStep) {
    buffer_->forget_moving();
    get_logger().warn("the clock was set back by {:.3f} s: moving transforms are forgotten",
                      to_seconds(*clock_offset_ - offset));
  }
  clock_offset_ = offset;
  for (const TransformStamped& transform : message.transforms) {
    const auto inserted =
        buffer_->insert(transform.header.frame_id, transform.child_frame_id, time_of(transform.header.stamp),
                        read(transform.transform), permanence, writer);
    if (inserted) continue;
    if (is_power_of_two(++refused_)) {
      const bool by_time = inserted.error() == spatial::InsertFault::TooOld;
      get_logger().warn("transform '{}' -> '{}' was refused ({} so far): {}{}", transform.header.frame_id,
                        transform.child_frame_id, refused_, spatial::to_text(inserted.error()),
                        by_time ? skews_->cause(writer) : "");
    }
  }
}

// At powers of two, so that a permanently wrong publisher is reported only a few times.
void TransformsComponent::tell_trouble() {
  const auto& stats = joints_->stats();
  if (stats.mismatched != told_mismatched_ && is_power_of_two(stats.mismatched)) {
    get_logger().warn("joint states with unlike numbers of names and positions were ignored ({} so far)",
                      stats.mismatched);
  }
  if (stats.unknown_joints != told_unknown_ && is_power_of_two(stats.unknown_joints)) {
    get_logger().warn("joint states name joints that the robot description does not have ({} so far)",
                      stats.unknown_joints);
  }
  told_mismatched_ = stats.mismatched;
  told_unknown_ = stats.unknown_joints;
}

}  // namespace nacelle::transforms
