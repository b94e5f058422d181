// SPDX-License-Identifier: Apache-2.0
// What is not used is counted by its cause and reported; the next good message is used as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "navsat_node.hpp"
#include "support/log_lines.hpp"

namespace nacelle::navsat {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using robot_localization::srv::FromLL;
using robot_localization::srv::ToLL;

const double kNoNumber = std::nan("");

class NavsatBadInput : public NavsatNode {
 protected:
  [[nodiscard]] std::string logged() const { return ::testing::PrintToString(lines_.all); }
  [[nodiscard]] DiagnosticStatus diagnostics() {
    const auto all = context_.published<DiagnosticArray>("/diagnostics");
    return all.empty() || all.back().status.empty() ? DiagnosticStatus{} : all.back().status[0];
  }
  [[nodiscard]] std::string value_of(const DiagnosticStatus& status, const std::string& key) {
    for (const auto& pair : status.values) {
      if (pair.key == key) return pair.value;
    }
    return "";
  }
  const test::LogLines lines_;
};

TEST_F(NavsatBadInput, fixes_that_are_none_are_counted_and_the_next_one_is_used) {
  start();
  align();
  auto none = fix({kNoNumber, kNoNumber, kNoNumber});
  none.status.status = sensor_msgs::msg::NavSatStatus::STATUS_NO_FIX;
  context_.inject("/gps/fix", none);
  for (const GeoPoint& bad : {GeoPoint{kNoNumber, kLongitude, 0.0}, GeoPoint{kLatitude, kLongitude, kNoNumber},
                              GeoPoint{kLatitude, std::numeric_limits<double>::infinity(), 0.0}})
    send_fix(bad);
  send_fix({90.5, kLongitude, 0.0});
  send_fix({kLatitude, -1e7, 0.0});
  context_.advance(1s);
  EXPECT_EQ(odometry().size(), 1U) << "the one of the alignment";
  const InputCounters& fixes = node_->stats().fixes;
  EXPECT_EQ(fixes.received, 7U);
  EXPECT_EQ(fixes.used, 1U);
  EXPECT_EQ(fixes.of(Refusal::NoFix), 1U);
  EXPECT_EQ(fixes.of(Refusal::NotFinite), 3U);
  EXPECT_EQ(fixes.of(Refusal::OutOfRange), 2U);
  EXPECT_NE(logged().find("gps/fix is not used: a value is not finite (3 so far)"), std::string::npos) << logged();
  EXPECT_EQ(diagnostics().level, DiagnosticStatus::WARN);
  EXPECT_EQ(value_of(diagnostics(), "fix_refused_out_of_range"), "2");
  send_fix(beside(1.0, 0.0));
  context_.advance(1s);
  EXPECT_EQ(odometry().size(), 2U);
  EXPECT_NE(logged().find("gps/fix is used again"), std::string::npos) << logged();
  EXPECT_EQ(diagnostics().level, DiagnosticStatus::OK);
}

TEST_F(NavsatBadInput, a_fix_on_the_other_side_of_the_earth_is_refused) {
  start();
  align();
  send_fix({-kLatitude, kLongitude - 180.0, 0.0});
  context_.advance(1s);
  EXPECT_EQ(odometry().size(), 1U);
  EXPECT_EQ(node_->stats().fixes.of(Refusal::TooFar), 1U);
  EXPECT_EQ(node_->stats().fixes.used, 1U);
}

TEST_F(NavsatBadInput, a_fix_without_covariance_gets_one_that_a_filter_can_use) {
  set("stddev_if_unknown", 2.0);
  start();
  align();
  auto unknown = fix(beside(1.0, 1.0));
  unknown.position_covariance = {};
  context_.inject("/gps/fix", unknown);
  context_.advance(100ms);
  unknown.position_covariance_type = NavSatFix::COVARIANCE_TYPE_UNKNOWN;
  context_.inject("/gps/fix", unknown);
  context_.advance(100ms);
  const auto all = odometry();
  ASSERT_EQ(all.size(), 3U);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_NEAR(all[i].pose.covariance[0], 4.0, 1e-9);
    EXPECT_NEAR(all[i].pose.covariance[14], 16.0, 1e-9);
  }
  EXPECT_EQ(node_->stats().unknown_covariance, 2U);
}

TEST_F(NavsatBadInput, the_border_of_a_utm_zone_is_counted_and_no_jump) {
  start();
  send_pose();
  send_imu(0.0);
  send_fix({50.0, 11.99999, 0.0});  // zone 32 ends at 12 degrees
  context_.advance(100ms);
  send_fix({50.0, 12.00001, 0.0});
  context_.advance(1s);
  EXPECT_NEAR(last().x(), 1.43, 0.02);
  EXPECT_NEAR(last().y(), 0.0, 0.02);
  EXPECT_EQ(node_->stats().other_zone, 1U);
  EXPECT_NE(logged().find("left the UTM zone"), std::string::npos) << logged();
}

TEST_F(NavsatBadInput, an_imu_without_orientation_or_heading_aligns_nothing) {
  start();
  for (int i = 0; i < 100; ++i) {
    send_pose();
    send_fix();
    sensor_msgs::msg::Imu raw;
    raw.orientation_covariance[0] = -1.0;
    context_.inject("/imu", raw);
    send_imu(Eigen::Quaterniond::Identity(), "base_link", M_PI * M_PI / 3.0);
    context_.advance(100ms);
  }
  EXPECT_FALSE(node_->is_aligned());
  EXPECT_EQ(node_->stats().imu.of(Refusal::NoOrientation), 100U);
  EXPECT_EQ(node_->stats().imu.of(Refusal::UnknownHeading), 100U);
  EXPECT_NE(logged().find("no output yet: waiting for an orientation on /imu"), std::string::npos) << logged();
  EXPECT_EQ(diagnostics().message, "waiting for an orientation on /imu");
  send_imu(0.0);
  context_.advance(200ms);
  EXPECT_TRUE(node_->is_aligned());
}

TEST_F(NavsatBadInput, an_imu_in_an_unknown_frame_is_waited_for) {
  start();
  send_pose();
  send_fix();
  send_imu(0.0, "nowhere");
  context_.advance(1s);
  EXPECT_FALSE(node_->is_aligned());
  EXPECT_NE(diagnostics().message.find("nowhere"), std::string::npos) << diagnostics().message;
  mount("nowhere", {});
  context_.advance(200ms);
  EXPECT_TRUE(node_->is_aligned());
}

TEST_F(NavsatBadInput, an_antenna_whose_place_is_unknown_counts_as_the_origin) {
  start();
  align();
  context_.inject("/gps/fix", fix(beside(3.0, 0.0), "somewhere"));
  context_.advance(100ms);
  context_.inject("/gps/fix", fix(beside(3.0, 0.0), ""));
  context_.advance(1s);
  EXPECT_NEAR(last().x(), 3.0, 0.01);
  EXPECT_EQ(node_->stats().without_antenna, 2U);
  EXPECT_NE(logged().find("no transform says where the antenna is"), std::string::npos) << logged();
}

TEST_F(NavsatBadInput, odometry_without_frames_or_numbers_is_refused) {
  start();
  Odometry bad;
  context_.inject("/odometry/filtered", bad);
  bad.header.frame_id = "map";
  bad.child_frame_id = "base_link";
  bad.pose.pose.position.x = kNoNumber;
  context_.inject("/odometry/filtered", bad);
  bad.pose.pose.position.x = 0.0;
  bad.pose.pose.orientation.w = 0.0;
  context_.inject("/odometry/filtered", bad);
  send_imu(0.0);
  send_fix();
  context_.advance(1s);
  EXPECT_FALSE(node_->is_aligned());
  const InputCounters& odometry = node_->stats().odometry;
  EXPECT_EQ(odometry.of(Refusal::NoFrame), 1U);
  EXPECT_EQ(odometry.of(Refusal::NotFinite), 1U);
  EXPECT_EQ(odometry.of(Refusal::NoOrientation), 1U);
  EXPECT_EQ(odometry.used, 0U);
}

TEST_F(NavsatBadInput, conversions_that_cannot_be_answer_with_not_a_number) {
  start();
  ToLL::Response there;
  FromLL::Response here;
  ASSERT_TRUE(context_.call<ToLL>("/toLL", {}, there));
  EXPECT_TRUE(std::isnan(there.ll_point.latitude)) << "not aligned yet";
  ASSERT_TRUE(context_.call<FromLL>("/fromLL", {}, here));
  EXPECT_TRUE(std::isnan(here.map_point.x));
  align();
  ToLL::Request far;
  far.map_point.x = 1e12;
  ASSERT_TRUE(context_.call<ToLL>("/toLL", far, there));
  EXPECT_TRUE(std::isnan(there.ll_point.longitude));
  FromLL::Request no_place;
  no_place.ll_point.latitude = kNoNumber;
  ASSERT_TRUE(context_.call<FromLL>("/fromLL", no_place, here));
  EXPECT_TRUE(std::isnan(here.map_point.y));
}

TEST_F(NavsatBadInput, a_datum_that_is_no_place_is_refused_at_configure) {
  for (const std::vector<double>& datum : {std::vector<double>{50.0, 9.0}, {95.0, 9.0, 0.0}, {50.0, 9.0, kNoNumber}}) {
    NodeOptions options{context_};
    options.append_parameter_override("datum", datum);
    options.append_parameter_override("wait_for_datum", true);
    NavsatTransformComponent node{options};
    const auto configured = node.trigger(Transition::Configure);
    EXPECT_FALSE(configured.success);
    EXPECT_NE(configured.reason.find("datum"), std::string::npos) << configured.reason;
  }
}

}  // namespace
}  // namespace nacelle::navsat
