// SPDX-License-Identifier: Apache-2.0
#include "navsat/component/navsat_transform_component.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "nacelle/qos/presets.hpp"

namespace nacelle::navsat {
namespace {

using robot_localization::srv::FromLL;
using robot_localization::srv::FromLLArray;
using robot_localization::srv::SetDatum;
using robot_localization::srv::SetUTMZone;
using robot_localization::srv::ToLL;

constexpr Duration kReportPeriod = 1s;
constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

GeoPoint point_of(const geographic_msgs::msg::GeoPoint& from) { return {from.latitude, from.longitude, from.altitude}; }

void write(const Result<GeoPoint, GeoFault>& point, geographic_msgs::msg::GeoPoint& out) {
  const GeoPoint none{kNaN, kNaN, kNaN};
  const GeoPoint& from = point ? *point : none;
  out.latitude = from.latitude_deg;
  out.longitude = from.longitude_deg;
  out.altitude = from.altitude_m;
}

void write(const Eigen::Vector3d& from, geometry_msgs::msg::Point& out) {
  out.x = from.x();
  out.y = from.y();
  out.z = from.z();
}

template <std::size_t Count>
void write_block(const Eigen::Matrix3d& from, std::array<double, Count>& out) {
  constexpr std::size_t kWidth = Count == 36 ? 6 : 3;
  out.fill(0.0);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      out[static_cast<std::size_t>(row) * kWidth + static_cast<std::size_t>(column)] = from(row, column);
  }
}

}  // namespace

NavsatTransformComponent::NavsatTransformComponent(const NodeOptions& options)
    : LifecycleNode("navsat_transform", options) {
  declare_navsat_parameters(*this);
  const auto read = read_navsat_parameters(*this);
  if (read) {
    options_ = *read;
  } else {
    declare_problem(read.error());
  }
  if (read && read->datum && !read->wait_for_datum) {
    declare_warning({Place::of_parameter("datum"),
                     "is not used: wait_for_datum is false, and the first fix is the datum",
                     "set wait_for_datum: true, or leave datum out"});
  }
  buffer_ =
      shared_object<spatial::TransformBuffer>(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer);
  gps_odometry_ = create_publisher<nav_msgs::msg::Odometry>("odometry/gps", QoS(10));
  if (options_.publish_filtered_gps) filtered_ = create_publisher<sensor_msgs::msg::NavSatFix>("gps/filtered", QoS(10));
  if (options_.broadcasts_cartesian)
    fixed_ = create_publisher<tf2_msgs::msg::TFMessage>("/tf_static", StaticTransformQoS());
  diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", QoS(10));
  fixes_ = create_subscription<sensor_msgs::msg::NavSatFix>(
      "gps/fix", SensorDataQoS(QoS(1)),
      [this](const sensor_msgs::msg::NavSatFix& message) { static_cast<void>(inputs_.take(message)); });
  odometry_ = create_subscription<nav_msgs::msg::Odometry>(
      "odometry/filtered", SensorDataQoS(QoS(1)),
      [this](const nav_msgs::msg::Odometry& message) { static_cast<void>(inputs_.take(message)); });
  // Always, so that a remap of it fits whatever the parameters say.
  imu_ = create_subscription<sensor_msgs::msg::Imu>("imu", SensorDataQoS(QoS(1)),
                                                    [this](const sensor_msgs::msg::Imu& message) {
                                                      if (options_.needs_imu())
                                                        static_cast<void>(inputs_.take(message));
                                                    });
  make_services();
}

void NavsatTransformComponent::make_services() {
  datum_service_ = create_service<SetDatum>(
      "datum", [this](const SetDatum::Request& request, SetDatum::Response&) { set_datum(request); });
  zone_service_ = create_service<SetUTMZone>(
      "setUTMZone", [this](const SetUTMZone::Request& request, SetUTMZone::Response&) { set_zone(request); });
  to_ll_ = create_service<ToLL>("toLL", [this](const ToLL::Request& request, ToLL::Response& response) {
    const auto& p = request.map_point;
    write(to_geo({p.x, p.y, p.z}), response.ll_point);
  });
  from_ll_ = create_service<FromLL>("fromLL", [this](const FromLL::Request& request, FromLL::Response& response) {
    write(from_geo(point_of(request.ll_point)).value_or(Eigen::Vector3d::Constant(kNaN)), response.map_point);
  });
  from_ll_array_ = create_service<FromLLArray>("fromLLArray", [this](const FromLLArray::Request& request,
                                                                     FromLLArray::Response& response) {
    response.map_points.resize(request.ll_points.size());
    for (std::size_t i = 0; i < request.ll_points.size(); ++i)
      write(from_geo(point_of(request.ll_points[i])).value_or(Eigen::Vector3d::Constant(kNaN)), response.map_points[i]);
  });
}

CallbackReturn NavsatTransformComponent::on_configure(const State&) {
  auto options = read_navsat_parameters(*this);
  if (!options) return refuse(options.error());
  options_ = std::move(options).value();
  inputs_ = NavsatInputs{{options_.zero_altitude, options_.stddev_if_unknown_m}};
  report_ = {};
  datum_ = options_.datum;
  uses_datum_ = options_.wait_for_datum;
  chosen_zone_.reset();
  forget_alignment();
  timer_ = create_timer(from_seconds(1.0 / options_.frequency_hz), [this] { tick(); });
  return CallbackReturn::SUCCESS;
}

CallbackReturn NavsatTransformComponent::on_activate(const State&) {
  begins_ = steady_clock().now() + options_.delay;
  next_report_ = steady_clock().now() + kReportPeriod;
  return CallbackReturn::SUCCESS;
}

CallbackReturn NavsatTransformComponent::on_deactivate(const State&) {
  const NavsatStats& s = stats();
  get_logger().info(
      "{} of {} fixes published; {} without a fix, {} not finite, {} out of range, {} too far from the datum, {} "
      "overtaken; {} without a covariance, {} of another zone, {} without the antenna's place",
      s.published, s.fixes.received, s.fixes.of(Refusal::NoFix), s.fixes.of(Refusal::NotFinite),
      s.fixes.of(Refusal::OutOfRange), s.fixes.of(Refusal::TooFar), s.overtaken, s.unknown_covariance, s.other_zone,
      s.without_antenna);
  return CallbackReturn::SUCCESS;
}

CallbackReturn NavsatTransformComponent::on_cleanup(const State&) {
  timer_.reset();
  claim_.reset();
  forget_alignment();
  return CallbackReturn::SUCCESS;
}

void NavsatTransformComponent::forget_alignment() {
  alignment_.reset();
  projection_.reset();
  waits_for_ = "the first output";
}

void NavsatTransformComponent::tick() {
  const MonotonicTime monotonic = steady_clock().now();
  if (monotonic >= begins_) {
    if (!alignment_) waits_for_ = align_frames();
    if (alignment_ && inputs_.pose()) {
      if (inputs_.has_new_fix()) publish_odometry();
      if (filtered_ && inputs_.has_new_pose()) publish_fix();
    }
  }
  report(monotonic);
}

std::string NavsatTransformComponent::align_frames() {
  if (!inputs_.pose()) return fmt::format("a pose on {}", odometry_->get_topic_name());
  return uses_datum_ ? align_with_datum() : align_with_fix();
}

std::string NavsatTransformComponent::align_with_datum() {
  if (!datum_) return fmt::format("a datum: call the service {}", datum_service_->get_service_name());
  const auto projection = project(datum_->point);
  const auto p_CW = projection ? projection->forward(datum_->point) : err(projection.error());
  if (!p_CW) return "a datum that the projection reaches";
  const auto R_CW = corrected(datum_->R_EW, correction(*projection));
  finish_alignment(*projection, align({}, *p_CW, R_CW, projection->convergence_rad()), datum_->point);
  return {};
}

std::string NavsatTransformComponent::align_with_fix() {
  const auto& pose = *inputs_.pose();
  if (!inputs_.fix()) return fmt::format("a fix on {}", fixes_->get_topic_name());
  Eigen::Quaterniond R_EB = pose.X_WB.rotation;
  if (!options_.use_odometry_yaw) {
    if (!inputs_.heading()) return fmt::format("an orientation on {}", imu_->get_topic_name());
    const auto& heading = *inputs_.heading();
    R_EB = heading.R_ES;
    if (!heading.frame.empty() && heading.frame != pose.base_frame) {
      const auto X_SB = buffer_->lookup_latest(heading.frame, pose.base_frame);
      if (!X_SB) return fmt::format("a transform: {}", X_SB.error().text());
      R_EB = heading.R_ES * X_SB->X_TS.rotation;
    }
  }
  const auto& fix = *inputs_.fix();
  const auto projection = project(fix.value.point);
  const auto p_CA = projection ? projection->forward(fix.value.point) : err(projection.error());
  if (!p_CA) {
    inputs_.refuse_fix(refusal_of(p_CA.error()));
    return "a fix that the projection reaches";
  }
  const auto R_CB = corrected(R_EB, correction(*projection));
  const Eigen::Vector3d p_BA = antenna(fix.frame, fix.stamp).value_or(Eigen::Vector3d::Zero());
  finish_alignment(*projection,
                   align(pose.X_WB, origin_of_base(*p_CA, R_CB, p_BA), R_CB, projection->convergence_rad()),
                   fix.value.point);
  return {};
}

Result<GeoProjection, GeoFault> NavsatTransformComponent::project(const GeoPoint& datum) const {
  return options_.use_local_cartesian ? GeoProjection::local(datum) : GeoProjection::utm(datum, chosen_zone_);
}

HeadingCorrection NavsatTransformComponent::correction(const GeoProjection& projection) const {
  HeadingCorrection all = options_.heading;
  all.convergence_rad = projection.convergence_rad();
  return all;
}

void NavsatTransformComponent::finish_alignment(const GeoProjection& projection, const Alignment& alignment,
                                                const GeoPoint& datum) {
  projection_ = projection;
  alignment_ = alignment;
  get_logger().info(
      "aligned: datum {:.7f}, {:.7f}, {:.2f} m; {}; the x axis of {} lies {:.2f} deg from the grid's east "
      "(declination {:.4f}, yaw_offset {:.4f}, convergence {:.4f} rad)",
      datum.latitude_deg, datum.longitude_deg, datum.altitude_m,
      projection.zone() ? "UTM zone " + to_text(*projection.zone()) : std::string("a local plane"),
      inputs_.pose()->world_frame, spatial::yaw_from_quaternion(alignment.X_CW.rotation) * kDegPerRad,
      options_.heading.declination_rad, options_.heading.yaw_offset_rad, projection.convergence_rad());
  broadcast();
}

std::optional<Eigen::Vector3d> NavsatTransformComponent::antenna(const std::string& frame, WallTime at) const {
  const std::string& base = inputs_.pose()->base_frame;
  if (frame == base) return Eigen::Vector3d::Zero();
  if (frame.empty()) return std::nullopt;
  auto X_BA = buffer_->lookup(base, frame, at);
  if (!X_BA) X_BA = buffer_->lookup_latest(base, frame);
  if (!X_BA) return std::nullopt;
  return X_BA->X_TS.translation_m;
}

Eigen::Quaterniond NavsatTransformComponent::attitude(WallTime at) const {
  const auto& pose = *inputs_.pose();
  const auto X_WB = buffer_->lookup(pose.world_frame, pose.base_frame, at);
  return X_WB ? X_WB->X_TS.rotation : pose.X_WB.rotation;
}

void NavsatTransformComponent::publish_odometry() {
  const auto& fix = *inputs_.fix();
  const auto p_CA = projection_->forward(fix.value.point);
  if (!p_CA) return inputs_.refuse_fix(refusal_of(p_CA.error()));
  if (projection_->is_in_another_zone(fix.value.point)) ++inputs_.stats.other_zone;
  inputs_.use_fix();
  Eigen::Vector3d p_W = alignment_->X_WC * *p_CA;
  if (const auto p_BA = antenna(fix.frame, fix.stamp)) {
    p_W = origin_of_base(p_W, attitude(fix.stamp), *p_BA);
  } else {
    ++inputs_.stats.without_antenna;
  }
  if (options_.zero_altitude) p_W.z() = 0.0;
  auto message = gps_odometry_->borrow();
  if (!message) return;  // every pooled message is still being read; the publisher counted it
  message->header.stamp = fix.stamp;
  message->header.frame_id = inputs_.pose()->world_frame;
  message->child_frame_id = inputs_.pose()->base_frame;
  write(p_W, message->pose.pose.position);
  message->pose.pose.orientation = {};
  write_block(covariance_in_world(*alignment_, fix.value.covariance_m2), message->pose.covariance);
  message->twist = {};
  gps_odometry_->publish(std::move(message));
  ++inputs_.stats.published;
}

void NavsatTransformComponent::publish_fix() {
  using sensor_msgs::msg::NavSatFix;
  const auto& pose = *inputs_.pose();
  inputs_.use_pose();
  const auto point = projection_->reverse(alignment_->X_CW * pose.X_WB.translation_m);
  if (!point) return;
  auto message = filtered_->borrow();
  if (!message) return;
  message->header.stamp = pose.stamp;
  message->header.frame_id = pose.base_frame;
  message->status.status = sensor_msgs::msg::NavSatStatus::STATUS_GBAS_FIX;
  message->latitude = point->latitude_deg;
  message->longitude = point->longitude_deg;
  message->altitude = point->altitude_m;
  write_block(covariance_of_fix(*alignment_, pose.position_covariance_m2), message->position_covariance);
  message->position_covariance_type = NavSatFix::COVARIANCE_TYPE_KNOWN;
  filtered_->publish(std::move(message));
}

void NavsatTransformComponent::broadcast() {
  if (!fixed_) return;
  const bool above = options_.cartesian_is_parent;
  const std::string& world = inputs_.pose()->world_frame;
  const std::string& parent = above ? options_.cartesian_frame : world;
  const std::string& child = above ? world : options_.cartesian_frame;
  if (!claim_) {
    claim_ = claim_frame(parent, child, FrameClaimKind::Fixed, Place::of_parameter("broadcast_cartesian_transform"));
  }
  if (!claim_->is_owner()) {
    get_logger().error("the frame '{}' is not broadcast: {} owns '{}'", options_.cartesian_frame, claim_->owner(),
                       child);
    return;
  }
  auto message = fixed_->borrow();
  if (!message) return;
  const RigidTransform& X = above ? alignment_->X_CW : alignment_->X_WC;
  message->transforms.resize(1);
  auto& transform = message->transforms[0];
  transform.header.stamp = now();
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  auto& to = transform.transform;
  to.translation.x = X.translation_m.x();
  to.translation.y = X.translation_m.y();
  to.translation.z = options_.zero_altitude ? 0.0 : X.translation_m.z();
  to.rotation.x = X.rotation.x();
  to.rotation.y = X.rotation.y();
  to.rotation.z = X.rotation.z();
  to.rotation.w = X.rotation.w();
  fixed_->publish(std::move(message));
}

void NavsatTransformComponent::report(MonotonicTime monotonic) {
  if (monotonic < next_report_) return;
  next_report_ = monotonic + kReportPeriod;
  report_.look(stats(), waits_for_, get_logger());
  auto message = diagnostics_->borrow();
  if (!message) return;
  message->header.stamp = now();
  message->header.frame_id.clear();
  report_.write(stats(), waits_for_, get_name(), *message);
  diagnostics_->publish(std::move(message));
}

Result<GeoPoint, GeoFault> NavsatTransformComponent::to_geo(const Eigen::Vector3d& p_W) const {
  if (!alignment_) {
    get_logger().error("toLL: the frames are not aligned yet: waiting for {}", waits_for_);
    return err(GeoFault::NotFinite);
  }
  auto point = projection_->reverse(alignment_->X_CW * p_W);
  if (!point) get_logger().error("toLL: {}", explain(refusal_of(point.error())));
  return point;
}

Result<Eigen::Vector3d, GeoFault> NavsatTransformComponent::from_geo(const GeoPoint& point) const {
  if (!alignment_) {
    get_logger().error("fromLL: the frames are not aligned yet: waiting for {}", waits_for_);
    return err(GeoFault::NotFinite);
  }
  const auto p_C = projection_->forward(point);
  if (!p_C) {
    get_logger().error("fromLL: {}", explain(refusal_of(p_C.error())));
    return err(p_C.error());
  }
  Eigen::Vector3d p_W = alignment_->X_WC * *p_C;
  if (options_.zero_altitude) p_W.z() = 0.0;
  return p_W;
}

void NavsatTransformComponent::set_datum(const SetDatum::Request& request) {
  const auto& pose = request.geo_pose;
  const Eigen::Quaterniond R{pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z};
  const bool is_place = check_position(pose.position.latitude, pose.position.longitude).has_value();
  const auto R_EW = check_orientation(R, {});
  if (!is_place || !std::isfinite(pose.position.altitude) || !R_EW) {
    get_logger().error("datum is ignored: {}",
                       is_place ? "its altitude or orientation is none" : "its latitude or longitude is none");
    return;
  }
  datum_ = ManualDatum{point_of(pose.position), *R_EW};
  uses_datum_ = true;
  forget_alignment();
}

void NavsatTransformComponent::set_zone(const SetUTMZone::Request& request) {
  const auto zone = read_utm_zone(request.utm_zone);
  if (!zone || options_.use_local_cartesian) {
    get_logger().error("setUTMZone '{}' is ignored: {}", request.utm_zone,
                       zone ? "use_local_cartesian is set" : "it is no zone such as 31U");
    return;
  }
  chosen_zone_ = zone;
  if (!uses_datum_) inputs_.forget_fix();
  forget_alignment();
}

}  // namespace nacelle::navsat
