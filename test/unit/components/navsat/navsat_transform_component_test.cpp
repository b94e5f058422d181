// SPDX-License-Identifier: Apache-2.0
#include "navsat/component/navsat_transform_component.hpp"

#include <gtest/gtest.h>

#include "navsat_node.hpp"

namespace nacelle::navsat {
namespace {

using robot_localization::srv::FromLL;
using robot_localization::srv::FromLLArray;
using robot_localization::srv::SetDatum;
using robot_localization::srv::SetUTMZone;
using robot_localization::srv::ToLL;
using spatial::kPi;
using spatial::quaternion_from_rpy;
using spatial::quaternion_from_yaw;
using tf2_msgs::msg::TFMessage;

// UTM's scale at the test's place is 0.9996: 4 mm in 10 m.
constexpr double kScale_m = 0.006;

TEST_F(NavsatNode, a_fix_becomes_a_position_in_the_world_of_the_filter) {
  start();
  align();
  send_fix(beside(10.0, 5.0, 2.0));
  context_.advance(100ms);
  const auto all = odometry();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[1].header.frame_id, "map");
  EXPECT_EQ(all[1].child_frame_id, "base_link");
  EXPECT_NEAR(all[1].pose.pose.position.x, 10.0, kScale_m) << "east";
  EXPECT_NEAR(all[1].pose.pose.position.y, 5.0, kScale_m) << "north";
  EXPECT_NEAR(all[1].pose.pose.position.z, 2.0, 1e-6);
  EXPECT_EQ(all[1].pose.pose.orientation.w, 1.0);
  EXPECT_NEAR(all[1].pose.covariance[0], 4.0, 0.001) << "east";
  EXPECT_NEAR(all[1].pose.covariance[7], 1.0, 0.001) << "north";
  EXPECT_NEAR(all[1].pose.covariance[14], 9.0, 1e-9);
  EXPECT_EQ(all[1].pose.covariance[35], 0.0) << "a fix has no orientation";
}

TEST_F(NavsatNode, each_fix_is_published_once_with_its_stamp) {
  start();
  align();
  const auto sent = fix(beside(1.0, 0.0));
  context_.advance(37ms);
  context_.inject("/gps/fix", sent);
  context_.advance(1s);
  const auto all = odometry();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[1].header.stamp, sent.header.stamp);
}

TEST_F(NavsatNode, the_heading_of_the_imu_turns_the_world) {
  start();
  align(kPi / 2.0);  // the robot, and the world's x axis, point north
  send_fix(beside(-3.0, 10.0));
  context_.advance(100ms);
  EXPECT_NEAR(last().x(), 10.0, kScale_m);
  EXPECT_NEAR(last().y(), 3.0, kScale_m) << "west is left";
}

TEST_F(NavsatNode, declination_and_yaw_offset_are_added_to_the_heading) {
  set("magnetic_declination_radians", 0.1);
  set("yaw_offset", 0.2);
  start();
  align(0.0);
  send_fix(beside(std::cos(0.3) * 10.0, std::sin(0.3) * 10.0));
  context_.advance(100ms);
  EXPECT_NEAR(last().x(), 10.0, kScale_m) << "straight ahead";
  EXPECT_NEAR(last().y(), 0.0, kScale_m);
}

TEST_F(NavsatNode, a_world_that_began_elsewhere_keeps_its_origin) {
  start();
  send_pose({quaternion_from_yaw(kPi / 2.0), {7.0, -4.0, 1.0}});
  send_imu(0.0);  // looks east in the world of the map's y axis
  send_fix();
  context_.advance(100ms);
  EXPECT_LT((last() - Eigen::Vector3d{7.0, -4.0, 1.0}).norm(), 1e-6);
  send_fix(beside(10.0, 0.0));
  context_.advance(100ms);
  EXPECT_LT((last() - Eigen::Vector3d{7.0, 6.0, 1.0}).norm(), kScale_m);
}

TEST_F(NavsatNode, the_antennas_place_is_taken_off_while_the_robot_turns) {
  mount("mast", {Eigen::Quaterniond::Identity(), {0.5, 0.2, 1.0}});
  start();
  send_pose();
  send_imu(0.0);
  context_.inject("/gps/fix", fix(beside(0.5, 0.2, 1.0), "mast"));
  context_.advance(100ms);
  EXPECT_LT(last().norm(), 0.001);
  // It turns on the spot: the antenna moves, the robot does not.
  for (const double yaw_rad : {0.5, kPi / 2.0, 3.0, -2.0}) {
    const Eigen::Vector3d p = quaternion_from_yaw(yaw_rad) * Eigen::Vector3d{0.5, 0.2, 1.0};
    send_pose({quaternion_from_yaw(yaw_rad), {0.0, 0.0, 0.0}});
    context_.inject("/gps/fix", fix(beside(p.x(), p.y(), p.z()), "mast"));
    context_.advance(100ms);
    EXPECT_LT(last().norm(), 0.001) << yaw_rad;
  }
  EXPECT_EQ(node_->stats().without_antenna, 0U);
}

TEST_F(NavsatNode, the_attitude_is_that_of_the_fixs_time) {
  mount("mast", {Eigen::Quaterniond::Identity(), {1.0, 0.0, 0.0}});
  start();
  align();
  const WallTime then = context_.clock().wall_now();
  for (int i = 0; i <= 10; ++i) {
    ASSERT_TRUE(buffer_->insert("map", "base_link", then + i * 100ms, {quaternion_from_yaw(0.1 * i), {0.0, 0.0, 0.0}},
                                spatial::Permanence::Dynamic));
  }
  auto late = fix(beside(std::cos(0.25), std::sin(0.25)), "mast");
  late.header.stamp = then + 250ms;
  send_pose({quaternion_from_yaw(1.0), {0.0, 0.0, 0.0}});
  context_.inject("/gps/fix", late);
  context_.advance(100ms);
  EXPECT_LT(last().head<2>().norm(), 0.001);
}

TEST_F(NavsatNode, an_imu_that_is_mounted_turned_and_tilted_gives_the_bases_heading) {
  const Eigen::Quaterniond R_BS = quaternion_from_rpy({0.7, -0.4, 2.0});
  mount("imu_link", {R_BS, {0.0, 0.0, 0.1}});
  start();
  send_pose();
  send_imu(quaternion_from_yaw(kPi / 2.0) * R_BS, "imu_link");
  send_fix();
  context_.advance(100ms);
  send_fix(beside(0.0, 10.0));
  context_.advance(100ms);
  EXPECT_NEAR(last().x(), 10.0, kScale_m) << "the robot looks north";
  EXPECT_NEAR(last().y(), 0.0, kScale_m);
}

TEST_F(NavsatNode, the_odometrys_yaw_can_be_the_heading) {
  set("use_odometry_yaw", true);
  start();
  send_pose({quaternion_from_yaw(1.1), {0.0, 0.0, 0.0}});
  send_fix();
  context_.advance(100ms);
  ASSERT_TRUE(node_->is_aligned());
  send_fix(beside(10.0, 5.0));
  context_.advance(100ms);
  EXPECT_NEAR(last().x(), 10.0, kScale_m);
  EXPECT_NEAR(last().y(), 5.0, kScale_m);
}

TEST_F(NavsatNode, a_datum_of_the_parameters_is_the_worlds_origin) {
  set("wait_for_datum", true);
  set("datum", std::vector<double>{kLatitude, kLongitude, kPi / 2.0});
  set("zero_altitude", true);
  set("use_local_cartesian", true);
  start();
  send_pose({quaternion_from_yaw(0.3), {2.0, 1.0, 0.0}});
  send_fix(beside(-1.0, 100.0));
  context_.advance(100ms);
  ASSERT_TRUE(node_->is_aligned());
  EXPECT_NEAR(last().x(), 100.0, 0.002) << "a local plane keeps lengths";
  EXPECT_NEAR(last().y(), 1.0, 0.002);
  EXPECT_EQ(last().z(), 0.0);
}

TEST_F(NavsatNode, a_datum_is_waited_for_and_can_be_moved) {
  set("wait_for_datum", true);
  start();
  send_pose();
  send_fix();
  context_.advance(1s);
  EXPECT_FALSE(node_->is_aligned());
  EXPECT_TRUE(odometry().empty());
  SetDatum::Request request;
  SetDatum::Response response;
  request.geo_pose.position.latitude = beside(0.0, -20.0).latitude_deg;
  request.geo_pose.position.longitude = kLongitude;
  request.geo_pose.position.altitude = kAltitude;
  ASSERT_TRUE(context_.call<SetDatum>("/datum", request, response));
  send_fix();
  context_.advance(200ms);
  EXPECT_LT((last() - Eigen::Vector3d{0.0, 20.0, 0.0}).norm(), 0.01);
  request.geo_pose.position.latitude = kLatitude;
  ASSERT_TRUE(context_.call<SetDatum>("/datum", request, response));
  send_fix();
  context_.advance(200ms);
  EXPECT_LT(last().norm(), 1e-6);
  request.geo_pose.position.latitude = 95.0;  // is ignored
  ASSERT_TRUE(context_.call<SetDatum>("/datum", request, response));
  EXPECT_TRUE(node_->is_aligned());
}

TEST_F(NavsatNode, the_filters_estimate_is_published_as_a_fix) {
  start();
  align(kPi / 2.0);
  send_pose({quaternion_from_yaw(0.0), {10.0, 3.0, 1.0}});
  context_.advance(100ms);
  const auto all = filtered();
  ASSERT_EQ(all.size(), 2U) << "one per pose";
  const GeoPoint expected = beside(-3.0, 10.0, 1.0);
  EXPECT_NEAR(all[1].latitude, expected.latitude_deg, 1e-7);
  EXPECT_NEAR(all[1].longitude, expected.longitude_deg, 1e-7);
  EXPECT_NEAR(all[1].altitude, expected.altitude_m, 1e-6);
  EXPECT_EQ(all[1].header.frame_id, "base_link");
  EXPECT_NEAR(all[1].position_covariance[0], 0.09, 1e-4) << "east is the world's y axis";
  EXPECT_NEAR(all[1].position_covariance[4], 0.25, 1e-4);
  EXPECT_EQ(all[1].position_covariance_type, NavSatFix::COVARIANCE_TYPE_KNOWN);
}

TEST_F(NavsatNode, publish_filtered_gps_false_publishes_none) {
  set("publish_filtered_gps", false);
  start();
  align();
  EXPECT_TRUE(filtered().empty());
}

TEST_F(NavsatNode, points_go_to_the_earth_and_back) {
  for (const bool is_local : {false, true}) {
    NodeOptions options{context_};
    options.append_parameter_override("use_local_cartesian", is_local);
    node_.reset();
    options_ = options;
    start();
    align(0.7);
    ToLL::Request to;
    ToLL::Response there;
    to.map_point.x = 123.4;
    to.map_point.y = -567.8;
    to.map_point.z = 9.0;
    ASSERT_TRUE(context_.call<ToLL>("/toLL", to, there));
    EXPECT_NEAR(there.ll_point.altitude, kAltitude + 9.0, 1e-6);
    FromLL::Request from;
    FromLL::Response back;
    from.ll_point = there.ll_point;
    ASSERT_TRUE(context_.call<FromLL>("/fromLL", from, back));
    EXPECT_NEAR(back.map_point.x, 123.4, 1e-6);
    EXPECT_NEAR(back.map_point.y, -567.8, 1e-6);
    EXPECT_NEAR(back.map_point.z, 9.0, 1e-6);
    FromLLArray::Request many;
    FromLLArray::Response all;
    many.ll_points = {there.ll_point, there.ll_point};
    many.ll_points[1].latitude = kLatitude;
    many.ll_points[1].longitude = kLongitude;
    many.ll_points[1].altitude = kAltitude;
    ASSERT_TRUE(context_.call<FromLLArray>("/fromLLArray", many, all));
    ASSERT_EQ(all.map_points.size(), 2U);
    EXPECT_NEAR(all.map_points[0].x, 123.4, 1e-6);
    EXPECT_NEAR(std::hypot(all.map_points[1].x, all.map_points[1].y), 0.0, 1e-6) << "the datum is the origin";
  }
}

TEST_F(NavsatNode, a_chosen_zone_is_used_from_the_next_fix_on) {
  set("broadcast_cartesian_transform", true);
  start();
  align();
  SetUTMZone::Request request;
  SetUTMZone::Response response;
  request.utm_zone = "31U";
  ASSERT_TRUE(context_.call<SetUTMZone>("/setUTMZone", request, response));
  EXPECT_FALSE(node_->is_aligned());
  align();
  send_fix(beside(10.0, 5.0));
  context_.advance(100ms);
  EXPECT_NEAR(last().x(), 10.0, 0.05) << "UTM stretches beyond its zone";
  EXPECT_NEAR(last().y(), 5.0, 0.05);
  const auto fixed = context_.published<TFMessage>("/tf_static");
  ASSERT_EQ(fixed.size(), 2U);
  EXPECT_EQ(fixed[1].transforms[0].header.frame_id, "map");
  EXPECT_EQ(fixed[1].transforms[0].child_frame_id, "utm");
  request.utm_zone = "north of the river";
  ASSERT_TRUE(context_.call<SetUTMZone>("/setUTMZone", request, response));
  EXPECT_TRUE(node_->is_aligned()) << "no zone: ignored";
}

TEST_F(NavsatNode, the_frame_of_the_projection_can_be_the_parent) {
  set("broadcast_utm_transform", true);
  set("broadcast_utm_transform_as_parent_frame", true);
  start();
  align();
  const auto fixed = context_.published<TFMessage>("/tf_static");
  ASSERT_EQ(fixed.size(), 1U);
  const auto& transform = fixed[0].transforms[0];
  EXPECT_EQ(transform.header.frame_id, "utm");
  EXPECT_EQ(transform.child_frame_id, "map");
  // Zone 32, whose meridian is at 9 degrees: the datum lies 25 km west of it.
  EXPECT_NEAR(transform.transform.translation.x, 475'000.0, 1'000.0);
  EXPECT_NEAR(transform.transform.translation.y, 5'524'000.0, 1'000.0);
}

TEST_F(NavsatNode, waits_for_the_delay) {
  set("delay", 2.0);
  start();
  for (int i = 0; i < 19; ++i) {
    send_pose();
    send_imu(0.0);
    send_fix();
    context_.advance(100ms);
  }
  EXPECT_FALSE(node_->is_aligned());
  context_.advance(200ms);
  EXPECT_TRUE(node_->is_aligned());
}

}  // namespace
}  // namespace nacelle::navsat
