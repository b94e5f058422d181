// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <robot_localization/srv/from_ll.hpp>
#include <robot_localization/srv/from_ll_array.hpp>
#include <robot_localization/srv/set_datum.hpp>
#include <robot_localization/srv/set_utm_zone.hpp>
#include <robot_localization/srv/to_ll.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/spatial/transform_buffer.hpp"
#include "navsat/component/navsat_inputs.hpp"
#include "navsat/component/navsat_options.hpp"
#include "navsat/component/navsat_report.hpp"

namespace nacelle::navsat {

/// robot_localization's navsat_transform_node as a component: gps/fix, imu and odometry/filtered in, odometry/gps and gps/filtered out.
///
/// It aligns the frames once: with the first fix, the heading of `imu` and the pose of odometry/filtered, or with a datum. Then each fix
/// becomes the position of the base in the world's frame, for a filter. The world's frame and the base's are those of odometry/filtered.
/// Services: datum, toLL, fromLL, fromLLArray, setUTMZone. Before the frames are aligned the conversions answer with NaN.
/// Threads: the component's executor. Allocates: nothing at the rate of the inputs and outputs once the frames are aligned.
class NavsatTransformComponent final : public LifecycleNode {
 public:
  explicit NavsatTransformComponent(const NodeOptions& options);

  [[nodiscard]] const NavsatStats& stats() const { return inputs_.stats; }
  [[nodiscard]] bool is_aligned() const { return alignment_.has_value(); }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  void make_services();
  void tick();
  /// Returns what is missing; empty if the frames are aligned now.
  std::string align_frames();
  std::string align_with_datum();
  std::string align_with_fix();
  void finish_alignment(const GeoProjection& projection, const Alignment& alignment, const GeoPoint& datum);
  void forget_alignment();
  [[nodiscard]] HeadingCorrection correction(const GeoProjection& projection) const;
  [[nodiscard]] Result<GeoProjection, GeoFault> project(const GeoPoint& datum) const;
  /// The antenna's place on the base; the base's origin if tf does not know it.
  [[nodiscard]] std::optional<Eigen::Vector3d> antenna(const std::string& frame, WallTime at) const;
  /// R_WB at a time, as well as tf and the newest pose know it.
  [[nodiscard]] Eigen::Quaterniond attitude(WallTime at) const;
  void publish_odometry();
  void publish_fix();
  void broadcast();
  void report(MonotonicTime monotonic);
  [[nodiscard]] Result<GeoPoint, GeoFault> to_geo(const Eigen::Vector3d& p_W) const;
  [[nodiscard]] Result<Eigen::Vector3d, GeoFault> from_geo(const GeoPoint& point) const;
  void set_datum(const robot_localization::srv::SetDatum::Request& request);
  void set_zone(const robot_localization::srv::SetUTMZone::Request& request);

  NavsatOptions options_;
  NavsatInputs inputs_{{}};
  NavsatReport report_;
  std::optional<ManualDatum> datum_;
  std::optional<UtmZone> chosen_zone_;
  std::optional<GeoProjection> projection_;
  std::optional<Alignment> alignment_;
  std::string waits_for_;
  bool uses_datum_ = false;
  MonotonicTime begins_{}, next_report_{};

  spatial::TransformBufferPtr buffer_;
  std::shared_ptr<Subscription<sensor_msgs::msg::NavSatFix>> fixes_;
  std::shared_ptr<Subscription<nav_msgs::msg::Odometry>> odometry_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Imu>> imu_;
  std::shared_ptr<Publisher<nav_msgs::msg::Odometry>> gps_odometry_;
  std::shared_ptr<Publisher<sensor_msgs::msg::NavSatFix>> filtered_;
  std::shared_ptr<Publisher<tf2_msgs::msg::TFMessage>> fixed_;
  std::shared_ptr<Publisher<diagnostic_msgs::msg::DiagnosticArray>> diagnostics_;
  std::shared_ptr<Service<robot_localization::srv::SetDatum>> datum_service_;
  std::shared_ptr<Service<robot_localization::srv::ToLL>> to_ll_;
  std::shared_ptr<Service<robot_localization::srv::FromLL>> from_ll_;
  std::shared_ptr<Service<robot_localization::srv::FromLLArray>> from_ll_array_;
  std::shared_ptr<Service<robot_localization::srv::SetUTMZone>> zone_service_;
  std::unique_ptr<FrameClaim> claim_;
  std::shared_ptr<Timer> timer_;
};

}  // namespace nacelle::navsat
