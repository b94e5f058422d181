// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/component/imu_filter_component.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "imu_filter/model/complementary_filter.hpp"
#include "imu_filter/model/madgwick_filter.hpp"
#include "nacelle/qos/presets.hpp"

namespace nacelle::imu_filter {
namespace {

constexpr double kGravityMps2 = 9.80665;
// A standard deviation of zero would claim a perfect filter, and an all-zero covariance means "unknown".
constexpr double kLeastStddev = 1e-12;
// Of an angle that may be anything: uniform over the circle.
constexpr double kUnknownAngleVariance = std::numbers::pi * std::numbers::pi / 3.0;
// A longer pause hides turns that the gyro did not report.
constexpr Duration kGap = 500ms;
// The clock was set back: waiting for it to catch up would stop the filter for as long.
constexpr Duration kClockStep = -1s;
constexpr Duration kOldestField = 250ms;
constexpr Duration kFieldPatience = 1s;

ParameterDescriptor text(std::string description) { return {.description = std::move(description)}; }
ParameterDescriptor within(std::string description, double from, double to) {
  return {.description = std::move(description), .floating_point_range = FloatingPointRange{from, to}};
}

template <typename XYZ>
Eigen::Vector3d vector_of(const XYZ& v) {
  return {v.x, v.y, v.z};
}

template <typename XYZ>
void write(const Eigen::Vector3d& v, XYZ& into) {
  into.x = v.x();
  into.y = v.y();
  into.z = v.z();
}

}  // namespace

ImuFilterComponent::ImuFilterComponent(const NodeOptions& options, bool use_mag)
    : LifecycleNode("imu_filter", options) {
  declare_parameter("use_mag", use_mag, text("use imu/mag; false: gyro and accelerometer only, the heading drifts"));
  declare_parameter("constant_dt", 0.0, within("s between two readings; 0: as their stamps say", 0.0, 10.0));
  declare_parameter("orientation_stddev", 0.05,
                    within("rad; standard deviation of roll, pitch and, with a field, yaw", kLeastStddev, 10.0));
  declare_parameter("world_frame", "enu", text("axes of the world: enu, nwu or ned"));
  declare_parameter("remove_gravity_vector", false, text("take gravity off the accelerations of imu/data"));
  declare_parameter("yaw_offset", 0.0, within("rad added to the heading", -2 * std::numbers::pi, 2 * std::numbers::pi));
  declare_parameter("declination", 0.0,
                    within("rad by which magnetic north lies east of true north", -std::numbers::pi, std::numbers::pi));
  for (const char* const axis : {"mag_bias_x", "mag_bias_y", "mag_bias_z"}) {
    declare_parameter(axis, 0.0, within("T subtracted from imu/mag: the field of the robot's own iron", -10.0, 10.0));
  }
  declare_parameter(
      "mag_gate_strength", 0.0,
      within("T; a field whose strength differs by more from the reference is not used; 0: off", 0.0, 1.0));
  declare_parameter(
      "mag_gate_dip", 0.0,
      within("rad; a field whose dip differs by more from the reference is not used; 0: off", 0.0, std::numbers::pi));
  declare_parameter("mag_reference_strength", 0.0,
                    within("T; the earth's field here; 0: strength and dip are learnt in the first second", 0.0, 1.0));
  declare_parameter(
      "mag_reference_dip", 0.0,
      within("rad below the horizon, with mag_reference_strength", -std::numbers::pi / 2, std::numbers::pi / 2));
  declare_parameter("mag_gate_patience", 10.0,
                    within("s; a field that is refused for so long and stays the same is used", 0.0, 1e6));
  const QoS qos = QoS(10).best_effort();
  data_ = create_publisher<sensor_msgs::msg::Imu>("imu/data", qos);
  raw_ = create_subscription<sensor_msgs::msg::Imu>("imu/data_raw", SensorDataQoS(QoS(10)),
                                                    [this](const sensor_msgs::msg::Imu& raw) { on_raw(raw); });
  field_ = create_subscription<sensor_msgs::msg::MagneticField>(
      "imu/mag", SensorDataQoS(QoS(10)), [this](const sensor_msgs::msg::MagneticField& field) { on_field(field); });
}

CallbackReturn ImuFilterComponent::on_configure(const State&) {
  options_ = {};
  options_.use_mag = get<bool>("use_mag");
  options_.constant_dt_s = get<double>("constant_dt");
  options_.orientation_stddev_rad = get<double>("orientation_stddev");
  options_.remove_gravity_vector = get<bool>("remove_gravity_vector");
  options_.yaw_offset_rad = get<double>("yaw_offset") - get<double>("declination");
  options_.mag_bias_t = {get<double>("mag_bias_x"), get<double>("mag_bias_y"), get<double>("mag_bias_z")};
  if (has_parameter("stateless")) options_.stateless = get<bool>("stateless");
  const auto world = get<std::string>("world_frame");
  if (world != "enu" && world != "nwu" && world != "ned") {
    return refuse(Problem{Place::of_parameter("world_frame", get_fully_qualified_name()),
                          fmt::format("'{}' is no world frame", world), "give enu, nwu or ned"});
  }
  options_.world = world == "enu" ? WorldFrame::enu() : world == "nwu" ? WorldFrame::nwu() : WorldFrame::ned();
  filter_ = make_filter(options_.world);
  const FieldGateOptions gate = read_field_gate();
  field_gate_.reset();
  if (gate.any()) field_gate_.emplace(gate);
  stats_ = {};
  return CallbackReturn::SUCCESS;
}

CallbackReturn ImuFilterComponent::on_activate(const State&) {
  // What the sensor did while inactive is unknown: the next reading starts anew. A bias that was learnt stays.
  last_stamp_.reset();
  last_field_t_.reset();
  up_S_.reset();
  waiting_since_.reset();
  return CallbackReturn::SUCCESS;
}

CallbackReturn ImuFilterComponent::on_deactivate(const State&) {
  get_logger().info(
      "{} of {} readings published: {} waited for a field, {} unusable, {} out of order, {} not sent since all "
      "messages were in use; {} gaps, {} without a field, {} unusable fields, {} fields of another strength or dip",
      stats_.published, stats_.received, stats_.waiting, stats_.unusable, stats_.out_of_order, stats_.unread,
      stats_.gaps, stats_.without_field, stats_.unusable_fields, stats_.gated_fields);
  return CallbackReturn::SUCCESS;
}

CallbackReturn ImuFilterComponent::on_cleanup(const State&) {
  filter_.reset();
  return CallbackReturn::SUCCESS;
}

void ImuFilterComponent::on_field(const sensor_msgs::msg::MagneticField& field) {
  if (!options_.use_mag) return;
  const Eigen::Vector3d value_t = vector_of(field.magnetic_field) - options_.mag_bias_t;
  if (!value_t.allFinite() || !(value_t.norm() > 0.0)) {
    ++stats_.unusable_fields;
    return;
  }
  if (field_gate_ && !fits(time_of(field.header.stamp), value_t)) return;
  last_field_t_ = value_t;
  last_field_stamp_ = time_of(field.header.stamp);
}

FieldGateOptions ImuFilterComponent::read_field_gate() const {
  FieldGateOptions gate;
  gate.strength_tolerance_t = get<double>("mag_gate_strength");
  gate.dip_tolerance_rad = get<double>("mag_gate_dip");
  gate.patience = from_seconds(get<double>("mag_gate_patience"));
  const auto strength_t = get<double>("mag_reference_strength");
  if (strength_t > 0.0) gate.reference = FieldShape{strength_t, get<double>("mag_reference_dip")};
  return gate;
}

bool ImuFilterComponent::fits(WallTime stamp, const Eigen::Vector3d& field_t) {
  const std::uint64_t adopted = field_gate_->adoptions();
  const std::optional<Eigen::Vector3d> up_S =
      last_stamp_ ? filter_->orientation().conjugate() * options_.world.up : up_S_;
  const auto verdict = field_gate_->judge(stamp, field_t, up_S);
  const FieldShape& seen = field_gate_->last();
  if (field_gate_->adoptions() > adopted)
    get_logger().warn(
        "{}: {:.1f} uT with a dip of {:.2f} rad, which the reference does not allow, stay the same: they are used from "
        "now on",
        field_->get_topic_name(), seen.strength_t * 1e6, seen.dip_rad);
  if (verdict == FieldGate::Verdict::Fits) return true;
  ++stats_.gated_fields;
  const FieldShape& reference = *field_gate_->reference();
  get_logger().warn_throttle(10s,
                             "{}: the field has {:.1f} uT and a dip of {:.2f} rad instead of {:.1f} uT and {:.2f} rad; "
                             "it is not used ({} so far)",
                             field_->get_topic_name(), seen.strength_t * 1e6, seen.dip_rad, reference.strength_t * 1e6,
                             reference.dip_rad, stats_.gated_fields);
  return false;
}

void ImuFilterComponent::on_raw(const sensor_msgs::msg::Imu& raw) {
  ++stats_.received;
  const WallTime stamp = time_of(raw.header.stamp);
  Measurement measurement{.angular_velocity_rps = vector_of(raw.angular_velocity),
                          .acceleration_mps2 = vector_of(raw.linear_acceleration)};
  const bool is_absent = raw.angular_velocity_covariance[0] == -1.0 || raw.linear_acceleration_covariance[0] == -1.0;
  if (is_absent || !measurement.angular_velocity_rps.allFinite() || !measurement.acceleration_mps2.allFinite()) {
    ++stats_.unusable;
    get_logger().warn_throttle(
        10s, "{}: {}; this reading is left out ({} so far)", raw_->get_topic_name(),
        is_absent ? "a covariance of -1 says that gyro or accelerometer are not there" : "a value is not finite",
        stats_.unusable);
    return;
  }
  if (const double force = measurement.acceleration_mps2.norm(); field_gate_ && !last_stamp_ && force > 0.0)
    up_S_ = measurement.acceleration_mps2 / force;
  if (last_field_t_) {
    const Duration age = stamp - last_field_stamp_;
    if (age <= kOldestField && age >= -kOldestField) measurement.magnetic_field = last_field_t_;
  }
  switch (advance(stamp, measurement)) {
    case Step::Waiting: ++stats_.waiting; return;
    case Step::OutOfOrder: ++stats_.out_of_order; return;
    case Step::Publish: break;
  }
  publish(raw, measurement.magnetic_field.has_value());
}

ImuFilterComponent::Step ImuFilterComponent::start(WallTime stamp, const Measurement& measurement) {
  if (options_.use_mag && !measurement.magnetic_field) {
    if (!waiting_since_) waiting_since_ = stamp;
    if (stamp - *waiting_since_ > kFieldPatience) {
      get_logger().warn_throttle(
          10s,
          "{}: no field has come for {:.1f} s, and the heading needs one to start; set use_mag to false without it",
          field_->get_topic_name(), to_seconds(stamp - *waiting_since_));
    }
    return Step::Waiting;
  }
  if (!filter_->start(measurement)) return Step::Waiting;
  last_stamp_ = stamp;
  return Step::Publish;
}

ImuFilterComponent::Step ImuFilterComponent::advance(WallTime stamp, Measurement& measurement) {
  if (!last_stamp_ || options_.stateless) return start(stamp, measurement);
  const Duration since = stamp - *last_stamp_;
  if (since <= Duration::zero() && since > kClockStep) return Step::OutOfOrder;
  last_stamp_ = stamp;
  if (since > kGap || since <= kClockStep) {
    ++stats_.gaps;
    filter_->level(measurement.acceleration_mps2);
    return Step::Publish;
  }
  measurement.dt_s = options_.constant_dt_s > 0.0 ? options_.constant_dt_s : to_seconds(since);
  filter_->update(measurement);
  if (options_.use_mag && !measurement.magnetic_field) {
    ++stats_.without_field;
    get_logger().warn_throttle(10s, "{}: no field for {:.1f} s; the gyro alone carries the heading",
                               field_->get_topic_name(), to_seconds(stamp - last_field_stamp_));
  }
  return Step::Publish;
}

void ImuFilterComponent::publish(const sensor_msgs::msg::Imu& raw, bool has_field) {
  auto message = data_->borrow();
  if (!message) {
    ++stats_.unread;
    return;
  }
  *message = raw;
  const Eigen::Quaterniond& R_WS = filter_->orientation();
  const Eigen::Quaterniond turned{
      Eigen::Quaterniond{Eigen::AngleAxisd{options_.yaw_offset_rad, Eigen::Vector3d::UnitZ()}} * R_WS};
  message->orientation.w = turned.w();
  message->orientation.x = turned.x();
  message->orientation.y = turned.y();
  message->orientation.z = turned.z();
  const double variance = options_.orientation_stddev_rad * options_.orientation_stddev_rad;
  message->orientation_covariance = {
      variance, 0.0,      0.0,
      0.0,      variance, 0.0,
      0.0,      0.0,      has_field ? variance : std::max(variance, kUnknownAngleVariance)};
  write(vector_of(raw.angular_velocity) - filter_->bias_rps(), message->angular_velocity);
  if (options_.remove_gravity_vector) {
    const Eigen::Vector3d gravity_S = R_WS.conjugate() * (kGravityMps2 * options_.world.up);
    write(vector_of(raw.linear_acceleration) - gravity_S, message->linear_acceleration);
  }
  ++stats_.published;
  data_->publish(std::move(message));
}

MadgwickFilterComponent::MadgwickFilterComponent(const NodeOptions& options) : ImuFilterComponent(options, true) {
  declare_parameter("gain", 0.1, within("how fast accelerometer and magnetometer pull; Madgwick's beta", 0.0, 1.0));
  declare_parameter("zeta", 0.0, within("how fast the gyro's bias is learnt, with a magnetometer", -1.0, 1.0));
  declare_parameter("stateless", false, text("take every orientation from one reading, without the gyro"));
}

std::unique_ptr<OrientationFilter> MadgwickFilterComponent::make_filter(const WorldFrame& world) const {
  return std::make_unique<MadgwickFilter>(world, MadgwickFilter::Settings{get<double>("gain"), get<double>("zeta")});
}

ComplementaryFilterComponent::ComplementaryFilterComponent(const NodeOptions& options)
    : ImuFilterComponent(options, false) {
  declare_parameter("gain_acc", 0.01, within("share of the tilt that one reading mends", 0.0, 1.0));
  declare_parameter("gain_mag", 0.01, within("share of the heading that one field mends", 0.0, 1.0));
  declare_parameter("do_bias_estimation", true, text("learn the gyro's bias while the sensor is at rest"));
  declare_parameter("bias_alpha", 0.01, within("share of a reading at rest that goes into the bias", 0.0, 1.0));
  declare_parameter("do_adaptive_gain", true, text("trust the accelerometer less while the sensor accelerates"));
}

std::unique_ptr<OrientationFilter> ComplementaryFilterComponent::make_filter(const WorldFrame& world) const {
  return std::make_unique<ComplementaryFilter>(
      world,
      ComplementaryFilter::Settings{get<double>("gain_acc"), get<double>("gain_mag"), get<bool>("do_bias_estimation"),
                                    get<double>("bias_alpha"), get<bool>("do_adaptive_gain")});
}

}  // namespace nacelle::imu_filter
