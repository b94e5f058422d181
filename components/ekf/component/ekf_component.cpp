// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/ekf_component.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "ekf/component/ekf_parameters.hpp"
#include "ekf/component/history_options.hpp"
#include "nacelle/qos/presets.hpp"

namespace nacelle::ekf {
namespace {

constexpr Duration kLookPeriod = 1s;

void write_rotation(const StateVector& x, geometry_msgs::msg::Quaternion& out) {
  const Eigen::Quaterniond q = spatial::quaternion_from_rpy({x[kRoll], x[kPitch], x[kYaw]});
  out.x = q.x();
  out.y = q.y();
  out.z = q.z();
  out.w = q.w();
}

template <std::size_t Count>
void write_block(const StateCovariance& covariance, int first, int size, std::array<double, Count>& out) {
  const auto width = static_cast<std::size_t>(Count == 36 ? 6 : 3);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j)
      out[static_cast<std::size_t>(i) * width + static_cast<std::size_t>(j)] = covariance(first + i, first + j);
  }
}

}  // namespace

EkfComponent::EkfComponent(const NodeOptions& options) : LifecycleNode("ekf", options) {
  declare_ekf_parameters(*this);
  for (const auto& [name, input] : parameters_of_absent_inputs(*this))
    declare_problem({Place::of_parameter(name),
                     fmt::format("parameter '{}' belongs to {}, which is not given", name, input),
                     "give " + input + " its topic, or leave it out"});
  for (const auto& input : inputs_without_config(*this))
    declare_problem({Place::of_parameter(input),
                     fmt::format("'{0}' has no '{0}_config': nothing of it is fused", input),
                     fmt::format("give {}_config 15 booleans (x y z, roll pitch yaw, vx vy vz, vroll vpitch vyaw, "
                                 "ax ay az), or leave the input out",
                                 input)});
  declare_history_warnings(*this);
  buffer_ =
      shared_object<spatial::TransformBuffer>(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer);
  skews_ = shared_object<ClockSkews>(kClockSkewsName, &make_clock_skews);
  buffer_->explain_by(skews_);
  odometry_ = create_publisher<nav_msgs::msg::Odometry>("odometry/filtered", QoS(10));
  transforms_ = create_publisher<tf2_msgs::msg::TFMessage>("/tf", DynamicTransformQoS());
  set_pose_topic_ = create_subscription<geometry_msgs::msg::PoseWithCovarianceStamped>(
      "set_pose", QoS(1), [this](const geometry_msgs::msg::PoseWithCovarianceStamped& message) { set_pose(message); });
  set_pose_service_ = create_service<robot_localization::srv::SetPose>(
      "set_pose", [this](const robot_localization::srv::SetPose::Request& request,
                         robot_localization::srv::SetPose::Response&) { set_pose(request.pose); });
  reset_service_ = create_service<std_srvs::srv::Empty>(
      "reset", [this](const std_srvs::srv::Empty::Request&, std_srvs::srv::Empty::Response&) { reset(); });
  enable_service_ = create_service<std_srvs::srv::Empty>(
      "enable", [this](const std_srvs::srv::Empty::Request&, std_srvs::srv::Empty::Response&) { enable(); });
  // What /diagnostics has, for `nacelle ekf`: computed only when asked, and there without print_diagnostics.
  using diagnostic_msgs::srv::SelfTest;
  status_service_ = create_service<SelfTest>(
      "~/status", [this](const SelfTest::Request&, SelfTest::Response& response) { answer_status(response); });
  using Toggle = robot_localization::srv::ToggleFilterProcessing;
  toggle_service_ = create_service<Toggle>(
      "toggle",
      [this](const Toggle::Request& request, Toggle::Response& response) { response.status = toggle(request.on); });

  // Declares here what the parameters name; problems with them are reported when the node is configured.
  const auto read = read_ekf_parameters(*this);
  if (!read) {
    declare_problem(read.error());
    return;
  }
  for (std::size_t i = 0; i < read->inputs.size(); ++i) {
    switch (read->inputs[i].kind) {
      case InputKind::Odometry: listen<nav_msgs::msg::Odometry>(i, read->inputs[i]); break;
      case InputKind::Pose: listen<geometry_msgs::msg::PoseWithCovarianceStamped>(i, read->inputs[i]); break;
      case InputKind::Twist: listen<geometry_msgs::msg::TwistWithCovarianceStamped>(i, read->inputs[i]); break;
      case InputKind::Imu: listen<sensor_msgs::msg::Imu>(i, read->inputs[i]); break;
    }
  }
  if (read->filter.control.any()) listen_to_commands(read->stamped_control);
  if (read->publish_acceleration)
    acceleration_ = create_publisher<geometry_msgs::msg::AccelWithCovarianceStamped>("accel/filtered", QoS(10));
  if (read->print_diagnostics)
    diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", QoS(10));
  if (read->publish_tf)
    claim_ =
        claim_frame(read->tf_parent(), read->tf_child(), FrameClaimKind::Primary, Place::of_parameter("publish_tf"));
  // With another name for the base, the inputs' frame may be known to them alone.
  if (read->base_link_frame_output == read->base_link_frame)
    declare_frame_use(read->base_link_frame, "base_link_frame");
  declare_frame_use(read->world_frame, "world_frame");
}

template <typename Message>
void EkfComponent::listen(std::size_t index, const InputOptions& input) {
  subscriptions_.push_back(create_subscription<Message>(input.topic,
                                                        SensorDataQoS(QoS(static_cast<std::size_t>(input.queue_size))),
                                                        [this, index](const Message& message, const MessageInfo& info) {
                                                          if (!enabled_ || !toggled_on_) return;
                                                          inputs_[index]->comes_from(info.writer_id, info.sequence);
                                                          inputs_[index]->take(message);
                                                        }));
}

void EkfComponent::listen_to_commands(bool stamped) {
  using geometry_msgs::msg::Twist;
  using geometry_msgs::msg::TwistStamped;
  SubscriptionOptions said;
  said.announced = Announced::WithItsPublisher;  // the base of the robot names the topic's type
  if (!stamped) {
    commands_ = create_subscription<Twist>(
        "cmd_vel", QoS(1), [this](const Twist& message) { command(message, now()); }, said);
    return;
  }
  commands_ = create_subscription<TwistStamped>(
      "cmd_vel", QoS(1),
      [this](const TwistStamped& message) {
        const std::string& frame = message.header.frame_id;
        if (frame.empty() || frame == options_->base_link_frame)
          return command(message.twist, time_of(message.header.stamp));
        if (std::exchange(told_command_frame_, true)) return;
        get_logger().warn("commands in the frame '{}' are not used: use_control takes them in base_link_frame ('{}')",
                          frame, options_->base_link_frame);
      },
      said);
}

void EkfComponent::command(const geometry_msgs::msg::Twist& twist, WallTime stamp) {
  const std::array<double, ControlOptions::kAxes> velocity{twist.linear.x,  twist.linear.y,  twist.linear.z,
                                                           twist.angular.x, twist.angular.y, twist.angular.z};
  for (const double v : velocity) {
    if (!std::isfinite(v)) return;
  }
  filter_->command(velocity, stamp);
}

CallbackReturn EkfComponent::on_configure(const State&) {
  auto options = read_ekf_parameters(*this);
  if (!options) {
    Problem problem = options.error();
    problem.where.node = get_fully_qualified_name();
    return refuse(problem);
  }
  options_ = std::move(options).value();
  for (const std::string& note : options_->notes) get_logger().warn("{}", note);
  std::uint16_t parts = 0;
  for (const InputOptions& input : options_->inputs) parts = static_cast<std::uint16_t>(parts + Input::parts_of(input));
  options_->filter.parts = parts;
  for (const InputOptions& input : options_->inputs)
    options_->filter.innovations.adaptive.insert(options_->filter.innovations.adaptive.end(), Input::parts_of(input),
                                                 input.adaptive_measurement_noise);
  filter_.emplace(options_->filter);
  inputs_.clear();
  std::uint16_t next = 0;
  for (const InputOptions& input : options_->inputs) {
    inputs_.push_back(
        std::make_unique<Input>(input, InputContext{&*filter_, buffer_.get(), &*options_, &steady_clock()}, next));
    next = static_cast<std::uint16_t>(next + inputs_.back()->parts().size());
  }
  if (const auto problem = open_debug_output()) return refuse(*problem);
  enabled_ = !options_->disabled_at_startup;
  toggled_on_ = true;
  follows_sim_time_ = get<bool>("use_sim_time");
  told_disabled_ = told_command_frame_ = told_no_odom_ = false;
  time_resets_ = 0;
  if (const History* const history = filter_->history()) get_logger().info("{}", in_words(*history));
  timer_ = create_timer(from_seconds(1.0 / options_->frequency_hz), [this] { tick(); });
  return CallbackReturn::SUCCESS;
}

CallbackReturn EkfComponent::on_activate(const State&) {
  for (const auto& input : inputs_) input->begin();
  filter_->resume();
  watch_.emplace(inputs_, *filter_, skews_);
  late_watch_.emplace(inputs_, *filter_);
  assist_watch_ = {};
  next_look_ = steady_clock().now() + kLookPeriod;
  return CallbackReturn::SUCCESS;
}

CallbackReturn EkfComponent::on_cleanup(const State&) {
  timer_.reset();
  watch_.reset();
  late_watch_.reset();
  inputs_.clear();
  filter_.reset();
  debug_.reset();
  options_.reset();
  return CallbackReturn::SUCCESS;
}

const PartStats* EkfComponent::stats(std::string_view part) const {
  for (const auto& input : inputs_) {
    for (const auto& p : input->parts()) {
      if (p.name == part) return &filter_->stats(p.number);
    }
  }
  return nullptr;
}

void EkfComponent::tick() {
  if (!enabled_) {
    if (!std::exchange(told_disabled_, true))
      get_logger().info("disabled_at_startup: call the service {} to begin", enable_service_->get_service_name());
    return;
  }
  const WallTime time = now();
  const MonotonicTime monotonic = steady_clock().now();
  // Simulated time may run at any rate: real time says nothing about it.
  const MonotonicTime beat = follows_sim_time_ ? MonotonicTime{} : monotonic;
  toggled_on_ ? filter_->step(time, beat) : filter_->hold(time, beat);
  if (filter_->time_resets() != std::exchange(time_resets_, filter_->time_resets())) after_time_reset();
  if (const auto output = filter_->output(time)) publish(*output);
  if (monotonic < next_look_) return;
  next_look_ = monotonic + kLookPeriod;
  if (toggled_on_) {
    watch_->look(inputs_, *filter_, get_logger());
    late_watch_->look(inputs_, *filter_, get_logger());
    assist_watch_.look(*filter_, *options_, get_logger());
  }
  if (!diagnostics_) return;
  auto message = diagnostics_->borrow();
  if (!message) return;
  message->header.stamp = time;
  message->header.frame_id.clear();
  write_diagnostics(inputs_, *filter_, get_name(), *message);
  write_history_diagnostics(*filter_, get_name(), *message);
  write_assist_diagnostics(*filter_, *options_, get_name(), *message);
  diagnostics_->publish(std::move(message));
}

void EkfComponent::publish(const Filter::Output& output) {
  const StateVector& x = output.belief->mean;
  auto message = odometry_->borrow();
  if (message) {
    message->header.stamp = output.stamp;
    message->header.frame_id = options_->world_frame;
    message->child_frame_id = options_->base_link_frame_output;
    auto& pose = message->pose.pose;
    pose.position.x = x[kX];
    pose.position.y = x[kY];
    pose.position.z = x[kZ];
    write_rotation(x, pose.orientation);
    auto& twist = message->twist.twist;
    twist.linear.x = x[kVx];
    twist.linear.y = x[kVy];
    twist.linear.z = x[kVz];
    twist.angular.x = x[kVroll];
    twist.angular.y = x[kVpitch];
    twist.angular.z = x[kVyaw];
    write_block(output.belief->covariance, kX, 6, message->pose.covariance);
    write_block(output.belief->covariance, kVx, 6, message->twist.covariance);
    odometry_->publish(std::move(message));
  }
  if (claim_ && claim_->is_owner()) publish_transform(output);
  if (acceleration_) publish_acceleration(output);
}

void EkfComponent::publish_transform(const Filter::Output& output) {
  const StateVector& x = output.belief->mean;
  RigidTransform X{spatial::quaternion_from_rpy({x[kRoll], x[kPitch], x[kYaw]}), {x[kX], x[kY], x[kZ]}};
  if (options_->corrects_odom()) {
    // map -> odom, from map -> base and the odometry's own odom -> base.
    const auto X_MO = map_to_odom(output);
    if (!X_MO) return;
    X = *X_MO;
  }
  auto message = transforms_->borrow();
  if (!message) return;
  message->transforms.resize(1);
  auto& transform = message->transforms[0];
  transform.header.stamp = output.stamp + options_->transform_time_offset;
  transform.header.frame_id = options_->tf_parent();
  transform.child_frame_id = options_->tf_child();
  transform.transform.translation.x = X.translation_m.x();
  transform.transform.translation.y = X.translation_m.y();
  transform.transform.translation.z = X.translation_m.z();
  transform.transform.rotation.x = X.rotation.x();
  transform.transform.rotation.y = X.rotation.y();
  transform.transform.rotation.z = X.rotation.z();
  transform.transform.rotation.w = X.rotation.w();
  transforms_->publish(std::move(message));
}

void EkfComponent::publish_acceleration(const Filter::Output& output) {
  const StateVector& x = output.belief->mean;
  auto message = acceleration_->borrow();
  if (!message) return;
  message->header.stamp = output.stamp;
  message->header.frame_id = options_->base_link_frame_output;
  auto& accel = message->accel.accel;
  accel.linear.x = x[kAx];
  accel.linear.y = x[kAy];
  accel.linear.z = x[kAz];
  const Eigen::Vector3d alpha_B = filter_->turning().alpha_B;
  accel.angular.x = alpha_B.x();
  accel.angular.y = alpha_B.y();
  accel.angular.z = alpha_B.z();
  message->accel.covariance.fill(0.0);
  write_block(output.belief->covariance, kAx, 3, message->accel.covariance);
  // A difference of two rates over a period. Source: robot_localization, RosFilter::differentiateMeasurements.
  const double per_period = 2.0 * options_->frequency_hz * options_->frequency_hz;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      message->accel.covariance[static_cast<std::size_t>((3 + i) * 6 + 3 + j)] =
          per_period * output.belief->covariance(kVroll + i, kVroll + j);
  }
  acceleration_->publish(std::move(message));
}

void EkfComponent::set_pose(const geometry_msgs::msg::PoseWithCovarianceStamped& message) {
  if (!filter_) return;  // a service call before it is configured
  const auto& pose = message.pose.pose;
  WallTime stamp = time_of(message.header.stamp);
  if (stamp == WallTime{} || stamp > now()) stamp = now();  // one from the future would silence the sensors until then
  RigidTransform X_WM;
  if (!message.header.frame_id.empty() && message.header.frame_id != options_->world_frame) {
    const auto found = buffer_->lookup_latest(options_->world_frame, message.header.frame_id);
    if (!found) {
      get_logger().error("set_pose is ignored: {}", found.error().text());
      return;
    }
    X_WM = found->X_TS;
  }
  const auto rotation = rotation_from(pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w);
  Reading reading;
  Prepared done = err(Rejection::NotFinite);
  if (rotation) {
    const Matrix6d covariance =
        Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.pose.covariance.data());
    const PartSetup all{.mask = kPoseMask, .two_d = options_->filter.two_d_mode};
    done =
        prepare_pose({*rotation, {pose.position.x, pose.position.y, pose.position.z}}, covariance, X_WM, all, reading);
    if (done) done = filter_->set_pose(reading, stamp);
  }
  if (!done) {
    get_logger().error("set_pose is ignored: {}", kRejectionNames[static_cast<std::size_t>(done.error())]);
    return;
  }
  for (const auto& input : inputs_) input->forget();
  get_logger().info("pose set to x {:.3f} y {:.3f}", filter_->belief().mean[kX], filter_->belief().mean[kY]);
}

void EkfComponent::enable() {
  if (enabled_) {
    get_logger().warn("the filter is enabled already; disabled_at_startup lets it wait for this service");
    return;
  }
  enabled_ = true;
  for (const auto& input : inputs_) input->begin();
  if (watch_) watch_.emplace(inputs_, *filter_, skews_);
  if (late_watch_) late_watch_.emplace(inputs_, *filter_);
  get_logger().info("enabled");
}

void EkfComponent::after_time_reset() {
  for (const auto& input : inputs_) input->forget();
  get_logger().warn("the time jumped back: reset to the initial state (reset_on_time_jump)");
}

void EkfComponent::answer_status(diagnostic_msgs::srv::SelfTest::Response& response) {
  response.id = get_name();
  response.passed = filter_ && filter_->initialised() ? 1 : 0;
  if (!filter_) return;  // before it is configured
  diagnostic_msgs::msg::DiagnosticArray all;
  write_diagnostics(inputs_, *filter_, get_name(), all);
  response.status = std::move(all.status);
}

void EkfComponent::reset() {
  if (!filter_) return;
  filter_->reset();
  for (const auto& input : inputs_) input->forget();
  get_logger().info("reset to the initial state");
}

}  // namespace nacelle::ekf
