// SPDX-License-Identifier: Apache-2.0
// The robot of the simulated world drives for minutes with two filters in one container: the one of the odometry drifts, the one of the
// map is held by the GPS. Bytes of the receiver go through its decoder; time is told.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "ekf/component/ekf_component.hpp"
#include "gps/model/error_model.hpp"
#include "gps/protocol/nmea_framer.hpp"
#include "navsat/component/navsat_transform_component.hpp"
#include "simulation/model/world_model.hpp"
#include "support/recording_host.hpp"
#include "transforms/component/transforms_component.hpp"

namespace nacelle::navsat {
namespace {

using ekf::EkfComponent;
using nav_msgs::msg::Odometry;
using sensor_msgs::msg::Imu;
using sensor_msgs::msg::NavSatFix;
using simulation::Device;
using simulation::Pose;

constexpr double kRadius_m = 1.0, kSpeed_mps = 0.3;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

std::vector<bool> fused(std::initializer_list<int> states) {
  std::vector<bool> config(15, false);
  for (const int state : states) config[static_cast<std::size_t>(state)] = true;
  return config;
}
constexpr int kX = 0, kY = 1, kVx = 6, kVy = 7, kVyaw = 11;

struct Errors {
  double worst_m{}, sum2_m2{};
  int count = 0;
  void add(double error_m) {
    worst_m = std::max(worst_m, error_m);
    sum2_m2 += error_m * error_m;
    ++count;
  }
  [[nodiscard]] double rms_m() const { return std::sqrt(sum2_m2 / count); }
};

class GpsWorld {
 public:
  explicit GpsWorld(std::uint64_t seed, double gps_error_m = 1.0)
      : settings_{.seed = seed, .gps = {.error_m = gps_error_m}}, world_(settings_), imu_(settings_) {
    buffer_ = std::static_pointer_cast<spatial::TransformBuffer>(
        context_.shared_object(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer));
    for (const char* const topic :
         {"/odom", "/tf", "/odometry/filtered", "/odometry/global", "/odometry/gps", "/gps/filtered"})
      context_.leave_unread(topic);
    NodeOptions mounts{context_};
    mounts.append_parameter_override("static_transforms",
                                     std::vector<std::string>{"-0.1 0 0.15 0 0 0 base_footprint gps_link"});
    start(transforms_, mounts);
    start(odom_filter_, filter_options("ekf", "odom"));
    NodeOptions map = filter_options("ekf_map", "map");
    map.remap_rules({RemapRule{.from = "odometry/filtered", .to = "odometry/global"}});
    map.append_parameter_override("odom1", std::string{"odometry/gps"});
    map.append_parameter_override("odom1_config", fused({kX, kY}));
    std::vector<double> noise{1e-3, 1e-3, 1e-6, 1e-6, 1e-6, 1e-4, 0.025, 0.025,
                              1e-6, 1e-6, 1e-6, 0.02, 0.01, 0.01, 1e-6};
    map.append_parameter_override("process_noise_covariance", noise);
    start(map_filter_, map);
    NodeOptions navsat{context_};
    navsat.remap_rules({RemapRule{.from = "odometry/filtered", .to = "odometry/global"}});
    navsat.append_parameter_override("wait_for_datum", true);
    navsat.append_parameter_override("datum",
                                     std::vector<double>{settings_.gps.latitude_deg, settings_.gps.longitude_deg, 0.0});
    navsat.append_parameter_override("zero_altitude", true);
    start(navsat_, navsat);
    watch_ = std::make_unique<Node>("watch", NodeOptions{context_});
    const auto remember = [this](const char* topic, Pose& last) {
      return watch_->create_subscription<Odometry>(topic, QoS(10), [&last](const Odometry& m) {
        last.x_m = m.pose.pose.position.x;
        last.y_m = m.pose.pose.position.y;
      });
    };
    by_odometry_ = remember("/odometry/filtered", odometry_);
    by_gps_ = remember("/odometry/global", map_);
  }

  /// Drives on a circle around the world's origin; what steers knows the truth.
  void drive(Duration length) {
    for (const Duration end = world_.now() + length; world_.now() < end;) {
      if (world_.now() % 100ms == 0s) steer();
      world_.step([this](Device device, ByteView bytes) {
        if (device == Device::Gps) hear(bytes);
      });
      if (world_.now() % 10ms == 0s) send_imu();
      if (world_.now() % 20ms == 0s) send_odometry();
      context_.advance(1ms);
      if (world_.now() % 1s == 0s) compare();
    }
  }

  void print(std::uint64_t seed) const {
    std::printf("seed %d: odometry %.3f m rms (worst %.3f), map %.3f m rms (worst %.3f), at the end %.3f m\n",
                static_cast<int>(seed), odometry_errors_.rms_m(), odometry_errors_.worst_m, map_errors_.rms_m(),
                map_errors_.worst_m, final_error_m());
  }
  [[nodiscard]] const Errors& odometry_errors() const { return odometry_errors_; }
  [[nodiscard]] const Errors& map_errors() const { return map_errors_; }
  [[nodiscard]] double final_error_m() const { return distance(map_); }
  [[nodiscard]] const NavsatStats& navsat() const { return navsat_->stats(); }
  [[nodiscard]] const simulation::WorldModel& world() const { return world_; }
  /// Between the base by /tf, from the map, and the map filter's own estimate.
  [[nodiscard]] double tf_differs_by_m() const {
    const auto X_MB = buffer_->lookup_latest("map", "base_footprint");
    return X_MB ? (X_MB->X_TS.translation_m.head<2>() - Eigen::Vector2d{map_.x_m, map_.y_m}).norm() : 1e9;
  }
  /// How far map -> odom moves the robot.
  [[nodiscard]] double correction_m() const { return std::hypot(map_.x_m - odometry_.x_m, map_.y_m - odometry_.y_m); }
  [[nodiscard]] double odometry_error_m() const { return distance(odometry_); }

 private:
  template <typename Component>
  void start(std::unique_ptr<Component>& component, const NodeOptions& options) {
    component = std::make_unique<Component>(options);
    const auto configured = component->trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(component->trigger(Transition::Activate).success);
  }
  NodeOptions filter_options(const std::string& name, const std::string& world_frame) {
    NodeOptions options{context_};
    options.node_name(name);
    options.append_parameter_override("frequency", 30.0);
    options.append_parameter_override("two_d_mode", true);
    options.append_parameter_override("world_frame", world_frame);
    options.append_parameter_override("base_link_frame", std::string{"base_footprint"});
    options.append_parameter_override("odom0", std::string{"odom"});
    options.append_parameter_override("odom0_config", fused({kVx, kVy}));
    options.append_parameter_override("imu0", std::string{"imu/data_raw"});
    options.append_parameter_override("imu0_config", fused({kVyaw}));
    return options;
  }
  [[nodiscard]] builtin_interfaces::msg::Time stamp() { return context_.clock().wall_now(); }

  void steer() {
    const Pose& truth = world_.drive().pose();
    const double angle_rad = std::atan2(truth.y_m, truth.x_m);
    const double outside_m = std::hypot(truth.x_m, truth.y_m) - kRadius_m;
    const double heading_rad = angle_rad + std::numbers::pi / 2.0 + std::atan(2.0 * outside_m);
    const double turn_rps =
        kSpeed_mps / kRadius_m + 2.0 * std::remainder(heading_rad - truth.yaw_rad, 2.0 * std::numbers::pi);
    world_.receive(Device::Base, as_bytes(fmt::format("{{\"T\":13,\"X\":{},\"Z\":{}}}\n", kSpeed_mps,
                                                      std::clamp(turn_rps, -1.5, 1.5))));
  }
  void send_imu() {
    const auto reading = imu_.measure(world_.drive());
    Imu m;
    m.header.stamp = stamp();
    m.header.frame_id = "base_footprint";
    m.orientation_covariance[0] = -1.0;
    m.angular_velocity.z = reading.angular_velocity_dps[2] * kRadPerDeg;
    for (std::size_t i = 0; i < 9; i += 4) m.angular_velocity_covariance[i] = 3e-6;
    context_.inject("/imu/data_raw", m);
  }
  /// As the odometry component has it: of nominal wheels.
  void send_odometry() {
    const simulation::DriveModel& drive = world_.drive();
    const auto& robot = settings_.robot;
    const double left_m = (drive.left_angle_rad() - left_rad_) * robot.wheel_radius_m;
    const double right_m = (drive.right_angle_rad() - right_rad_) * robot.wheel_radius_m;
    left_rad_ = drive.left_angle_rad();
    right_rad_ = drive.right_angle_rad();
    Odometry m;
    m.header.stamp = stamp();
    m.header.frame_id = "odom";
    m.child_frame_id = "base_footprint";
    m.twist.twist.linear.x = (left_m + right_m) / 2.0 / 0.02;
    m.twist.twist.angular.z = (right_m - left_m) / robot.track_m / 0.02;
    for (std::size_t i = 0; i < 6; ++i) m.twist.covariance[i * 7] = 1e-3;
    context_.inject("/odom", m);
  }
  void hear(ByteView bytes) {
    framer_.feed(bytes, context_.clock().now(), [this](const gps::NmeaSentence& sentence) {
      const auto message = gps::read_nmea(sentence.text);
      if (const auto* const gst = std::get_if<gps::Gst>(&message)) errors_.add(*gst, context_.clock().now());
      if (const auto* const gga = std::get_if<gps::Gga>(&message)) publish(*gga);
    });
  }
  void publish(const gps::Gga& gga) {
    const auto variances = errors_.of(gga, context_.clock().now());
    NavSatFix m;
    m.header.stamp = stamp();
    m.header.frame_id = "gps_link";
    m.status.status = sensor_msgs::msg::NavSatStatus::STATUS_FIX;
    m.latitude = gga.position->latitude_deg;
    m.longitude = gga.position->longitude_deg;
    m.altitude = *gga.above_geoid_m + *gga.geoid_m;
    m.position_covariance = {variances.east_m2, 0.0, 0.0, 0.0, variances.north_m2, 0.0, 0.0, 0.0, variances.up_m2};
    m.position_covariance_type = NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
    context_.inject("/gps/fix", m);
  }
  [[nodiscard]] double distance(const Pose& estimate) const {
    const Pose& truth = world_.drive().pose();
    return std::hypot(estimate.x_m - truth.x_m, estimate.y_m - truth.y_m);
  }
  void compare() {
    if (world_.now() < 60s) return;  // the GPS needs time to say more than the start
    odometry_errors_.add(distance(odometry_));
    map_errors_.add(distance(map_));
  }

  test::RecordingContext context_;
  const simulation::WorldSettings settings_;
  simulation::WorldModel world_;
  simulation::ImuModel imu_;
  gps::NmeaFramer framer_;
  gps::ErrorModel errors_;
  spatial::TransformBufferPtr buffer_;
  std::unique_ptr<transforms::TransformsComponent> transforms_;
  std::unique_ptr<EkfComponent> odom_filter_, map_filter_;
  std::unique_ptr<NavsatTransformComponent> navsat_;
  std::unique_ptr<Node> watch_;
  std::shared_ptr<Subscription<Odometry>> by_odometry_, by_gps_;
  Pose odometry_, map_;
  Errors odometry_errors_, map_errors_;
  double left_rad_ = 0.0, right_rad_ = 0.0;
};

// A sanitizer's robot takes fifteen times as long: there the second test drives through the same code for as long as errors count.
#ifdef NACELLE_SANITIZED
constexpr Duration kCorrectedDrive = 65s;
#else
constexpr Duration kCorrectedDrive = 120s;

TEST(GpsWorld, the_map_filter_takes_off_the_drift_of_the_odometry) {
  for (const std::uint64_t seed : {2U, 3U}) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    GpsWorld robot{seed};
    robot.drive(300s);
    robot.print(seed);
    EXPECT_EQ(robot.world().drive().contacts(), 0U) << "the path is free";
    EXPECT_NEAR(static_cast<double>(robot.navsat().published), 1500.0, 10.0) << "5 Hz";
    EXPECT_EQ(robot.navsat().without_antenna, 0U);
    // The GPS errs by 0.9 m rms in each direction.
    EXPECT_LT(robot.map_errors().rms_m(), 0.35);
    EXPECT_LT(robot.final_error_m(), 0.6);
    EXPECT_LT(robot.map_errors().rms_m(), robot.odometry_errors().rms_m());
    EXPECT_LT(robot.tf_differs_by_m(), 0.05) << "map -> odom -> base is the map filter's estimate";
    EXPECT_GT(robot.odometry_error_m(), 0.1) << "there is something to correct";
    EXPECT_NEAR(robot.correction_m(), robot.odometry_error_m(), 0.3) << "map -> odom takes the drift off";
  }
}
#endif

TEST(GpsWorld, a_receiver_with_corrections_is_followed_to_centimetres) {
  GpsWorld robot{4, 0.02};
  robot.drive(kCorrectedDrive);
  robot.print(4);
  EXPECT_LT(robot.map_errors().worst_m, 0.10);
  EXPECT_LT(robot.map_errors().rms_m(), 0.05);
}

}  // namespace
}  // namespace nacelle::navsat
