// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/component/imu_filter_component.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "imu_filter/model/complementary_filter.hpp"
#include "imu_filter/model/madgwick_filter.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::imu_filter {
namespace {

using sensor_msgs::msg::Imu;
using sensor_msgs::msg::MagneticField;

class ImuFilterNode : public ::testing::Test {
 protected:
  void set(const std::string& name, const ParameterValue& value) { options_.append_parameter_override(name, value); }
  void start() {
    node_ = std::make_unique<MadgwickFilterComponent>(options_);
    ASSERT_TRUE(node_->trigger(Transition::Configure).success);
    ASSERT_TRUE(node_->trigger(Transition::Activate).success);
  }
  template <typename Message>
  void stamp(Message& message) const {
    message.header.stamp = WallTime{100s + ms_ * 1ms};
    message.header.frame_id = "imu_link";
  }
  Imu at_rest() const {
    Imu raw;
    stamp(raw);
    raw.linear_acceleration.z = 9.80665;
    raw.linear_acceleration_covariance = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
    raw.angular_velocity_covariance = {1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4};
    raw.orientation_covariance[0] = -1.0;
    return raw;
  }
  void send(const Imu& raw) { context_.inject("/imu/data_raw", raw); }
  void send_field(double x, double y, double z = -43e-6) {
    MagneticField field;
    stamp(field);
    field.magnetic_field.x = x;
    field.magnetic_field.y = y;
    field.magnetic_field.z = z;
    context_.inject("/imu/mag", field);
  }
  std::vector<Imu> published() { return context_.published<Imu>("/imu/data"); }
  static double yaw_of(const Imu& imu) { return 2.0 * std::atan2(imu.orientation.z, imu.orientation.w); }
  void expect_that_all_is_accounted_for() const {
    const auto& s = node_->stats();
    EXPECT_EQ(s.received, s.published + s.waiting + s.unusable + s.out_of_order + s.unread);
  }

  test::RecordingContext context_;
  NodeOptions options_{context_};
  std::unique_ptr<ImuFilterComponent> node_;
  std::int64_t ms_ = 0;
};

TEST_F(ImuFilterNode, waits_for_a_field_and_then_publishes_each_reading_with_its_stamp_and_frame) {
  start();
  send(at_rest());
  EXPECT_TRUE(published().empty());
  ms_ += 10;
  send_field(0.0, 20e-6);  // the sensor's y points north: ENU's identity
  send(at_rest());
  ASSERT_EQ(published().size(), 1U);
  const Imu data = published().back();
  EXPECT_EQ(data.header.stamp.nanosec, 10'000'000U);
  EXPECT_EQ(data.header.frame_id, "imu_link");
  EXPECT_NEAR(data.orientation.w, 1.0, 1e-9);
  EXPECT_NEAR(data.linear_acceleration.z, 9.80665, 1e-9);
  EXPECT_EQ(data.angular_velocity_covariance[0], 1e-4);
  expect_that_all_is_accounted_for();
}

TEST_F(ImuFilterNode, heading_is_that_of_the_sensors_x_axis_from_east) {
  start();
  send_field(20e-6, 0.0);  // x points north
  send(at_rest());
  ASSERT_EQ(published().size(), 1U);
  EXPECT_NEAR(yaw_of(published()[0]), std::numbers::pi / 2, 1e-9);
}

TEST_F(ImuFilterNode, adds_the_yaw_offset_and_takes_the_declination_off) {
  set("yaw_offset", 0.3);
  set("declination", 0.1);
  start();
  send_field(0.0, 20e-6);
  send(at_rest());
  ASSERT_EQ(published().size(), 1U);
  EXPECT_NEAR(yaw_of(published()[0]), 0.2, 1e-9);
}

TEST_F(ImuFilterNode, takes_the_field_of_the_robots_iron_off) {
  set("mag_bias_x", 30e-6);
  start();
  send_field(30e-6, 20e-6);
  send(at_rest());
  ASSERT_EQ(published().size(), 1U);
  EXPECT_NEAR(yaw_of(published()[0]), 0.0, 1e-9);
}

TEST_F(ImuFilterNode, a_heading_without_a_field_has_the_variance_of_an_unknown_angle) {
  set("use_mag", false);
  start();
  send(at_rest());
  ASSERT_EQ(published().size(), 1U);
  const auto covariance = published()[0].orientation_covariance;
  EXPECT_NEAR(covariance[0], 0.0025, 1e-12);
  EXPECT_NEAR(covariance[4], 0.0025, 1e-12);
  EXPECT_NEAR(covariance[8], std::numbers::pi * std::numbers::pi / 3, 1e-12);
}

TEST_F(ImuFilterNode, goes_on_without_a_field_that_went_away_and_says_so_in_the_covariance) {
  start();
  send_field(0.0, 20e-6);
  send(at_rest());
  ms_ += 200;
  send(at_rest());
  ms_ += 200;
  send(at_rest());
  ASSERT_EQ(published().size(), 3U);
  EXPECT_NEAR(published()[1].orientation_covariance[8], 0.0025, 1e-12);
  EXPECT_GT(published()[2].orientation_covariance[8], 3.0);
  EXPECT_EQ(node_->stats().without_field, 1U);
}

TEST_F(ImuFilterNode, turns_with_the_gyro) {
  set("use_mag", false);
  start();
  for (int i = 0; i < 101; ++i) {
    Imu raw = at_rest();
    raw.angular_velocity.z = 1.0;
    send(raw);
    ms_ += 10;
  }
  EXPECT_NEAR(yaw_of(published().back()), 1.0, 1e-6);
}

TEST_F(ImuFilterNode, a_reading_that_is_not_later_or_not_finite_is_left_out) {
  set("use_mag", false);
  start();
  send(at_rest());
  send(at_rest());
  ms_ -= 5;
  send(at_rest());
  ms_ += 15;
  Imu raw = at_rest();
  raw.angular_velocity.x = std::numeric_limits<double>::quiet_NaN();
  send(raw);
  raw = at_rest();
  raw.linear_acceleration_covariance[0] = -1.0;
  send(raw);
  EXPECT_EQ(published().size(), 1U);
  EXPECT_EQ(node_->stats().out_of_order, 2U);
  EXPECT_EQ(node_->stats().unusable, 2U);
  expect_that_all_is_accounted_for();
}

TEST_F(ImuFilterNode, after_a_gap_or_a_clock_that_was_set_back_it_levels_and_goes_on) {
  set("use_mag", false);
  start();
  send(at_rest());
  ms_ += 2000;
  Imu raw = at_rest();
  raw.angular_velocity.z = 3.0;  // that it has turned like this all the time is not known
  raw.linear_acceleration.x = raw.linear_acceleration.z;
  send(raw);
  ASSERT_EQ(published().size(), 2U);
  EXPECT_EQ(node_->stats().gaps, 1U);
  EXPECT_NEAR(published()[1].orientation.y, -std::sin(std::numbers::pi / 8), 1e-9);
  EXPECT_NEAR(published()[1].orientation.z, 0.0, 1e-9);
  ms_ -= 60000;
  send(at_rest());
  EXPECT_EQ(published().size(), 3U);
  EXPECT_EQ(node_->stats().gaps, 2U);
}

TEST_F(ImuFilterNode, takes_gravity_off_if_asked) {
  set("use_mag", false);
  set("remove_gravity_vector", true);
  start();
  Imu raw = at_rest();
  send(raw);
  EXPECT_NEAR(published().back().linear_acceleration.z, 0.0, 1e-9);
}

TEST_F(ImuFilterNode, an_unknown_world_frame_is_refused_with_those_that_there_are) {
  set("world_frame", std::string{"eun"});
  MadgwickFilterComponent node{options_};
  const auto outcome = node.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("give enu, nwu or ned"), std::string::npos) << outcome.reason;
}

TEST_F(ImuFilterNode, a_field_of_another_strength_is_counted_and_not_used) {
  set("mag_gate_strength", 5e-6);
  start();
  for (int i = 0; i < 150; ++i, ms_ += 10) {
    send_field(0.0, 20e-6);
    send(at_rest());
  }
  const double before = yaw_of(published().back());
  for (int i = 0; i < 100; ++i, ms_ += 10) {
    send_field(60e-6, 20e-6);
    send(at_rest());
  }
  EXPECT_EQ(node_->stats().gated_fields, 100U);
  EXPECT_NEAR(yaw_of(published().back()), before, 1e-3) << "without the gate the heading follows the iron";
  EXPECT_GT(published().back().orientation_covariance[8], 1.0);
}

TEST_F(ImuFilterNode, takes_nothing_from_the_heap_per_reading) {
  Measurement m{.dt_s = 0.01};
  m.acceleration_mps2 = {0.1, 0.2, 9.8};
  m.magnetic_field = Eigen::Vector3d{0, 20e-6, -43e-6};
  MadgwickFilter madgwick{WorldFrame::enu(), {}};
  ComplementaryFilter complementary{WorldFrame::enu(), {}};
  const test::AllocationGuard guard;
  for (OrientationFilter* const filter :
       {static_cast<OrientationFilter*>(&madgwick), static_cast<OrientationFilter*>(&complementary)}) {
    ASSERT_TRUE(filter->start(m));
    for (int i = 0; i < 100; ++i) filter->update(m);
  }
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(ImuFilterNode, the_complementary_filter_needs_no_field_by_default) {
  ComplementaryFilterComponent node{options_};
  ASSERT_TRUE(node.trigger(Transition::Configure).success);
  ASSERT_TRUE(node.trigger(Transition::Activate).success);
  send(at_rest());
  EXPECT_EQ(published().size(), 1U);
}

}  // namespace
}  // namespace nacelle::imu_filter
