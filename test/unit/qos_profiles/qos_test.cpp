// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/qos.hpp"

#include <gtest/gtest.h>

#include "nacelle/qos/presets.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle {
namespace {

TEST(QoS, is_built_in_rclcpps_words) {
  const QoS q = QoS(KeepLast(7))
                    .best_effort()
                    .transient_local()
                    .deadline(100ms)
                    .lifespan(2s)
                    .liveliness(Liveliness::Automatic)
                    .liveliness_lease_duration(1s);

  EXPECT_EQ(q.history(), History::KeepLast);
  EXPECT_EQ(q.depth(), 7U);
  EXPECT_EQ(q.reliability(), Reliability::BestEffort);
  EXPECT_EQ(q.durability(), Durability::TransientLocal);
  EXPECT_EQ(q.deadline(), Duration{100ms});
  EXPECT_EQ(q.lifespan(), Duration{2s});
  EXPECT_EQ(q.liveliness(), Liveliness::Automatic);
  EXPECT_EQ(q.liveliness_lease_duration(), Duration{1s});
}

TEST(QoS, of_a_number_is_rmws_default_profile_with_that_depth) {
  EXPECT_EQ(to_text(QoS(10)), "keep_last 10, reliable, volatile");
  EXPECT_EQ(QoS(10).deadline(), Duration::zero());
}

TEST(QoS, treats_an_infinite_duration_and_none_as_the_same) { EXPECT_EQ(QoS(1).deadline(Duration::max()), QoS(1)); }

TEST(QoS, holds_max_samples_with_keep_all_and_the_depth_otherwise) {
  EXPECT_EQ(QoS(KeepAll()).queue_capacity(), 1000U);
  EXPECT_EQ(QoS(KeepAll()).max_samples(20).queue_capacity(), 20U);
  EXPECT_EQ(QoS(3).queue_capacity(), 3U);
  EXPECT_EQ(QoS(0).queue_capacity(), 1U);
}

TEST(QoS, resolves_system_defaults_to_cyclones) {
  const QoS q = SystemDefaultsQoS().resolved();
  EXPECT_EQ(q, QoS(1).liveliness(Liveliness::Automatic));
  EXPECT_EQ(q.resolved(), q);
}

TEST(QoS, differs_in_each_of_its_values) {
  const QoS base(10);
  EXPECT_NE(QoS(base).keep_last(9), base);
  EXPECT_NE(QoS(base).keep_all(), base);
  EXPECT_NE(QoS(base).best_effort(), base);
  EXPECT_NE(QoS(base).transient_local(), base);
  EXPECT_NE(QoS(base).deadline(1ns), base);
  EXPECT_NE(QoS(base).lifespan(1ns), base);
  EXPECT_NE(QoS(base).liveliness(Liveliness::ManualByTopic), base);
  EXPECT_NE(QoS(base).liveliness_lease_duration(1ns), base);
  EXPECT_NE(QoS(base).max_samples(3), base);
  EXPECT_NE(QoS(base).max_blocking_time(1ms), base);
}

// Source: rmw/qos_profiles.h and the headers named in presets.hpp, written down value by value.
TEST(Presets, are_those_of_ros_2) {
  EXPECT_EQ(to_text(SensorDataQoS()), "keep_last 5, best_effort, volatile");
  EXPECT_EQ(to_text(SystemDefaultsQoS()), "system_default, system_default, system_default");
  EXPECT_EQ(to_text(ServicesQoS()), "keep_last 10, reliable, volatile");
  EXPECT_EQ(to_text(ParametersQoS()), "keep_last 1000, reliable, volatile");
  EXPECT_EQ(to_text(ParameterEventsQoS()), "keep_last 1000, reliable, volatile");
  EXPECT_EQ(to_text(RosoutQoS()), "keep_last 1000, reliable, transient_local, lifespan 10s");
  EXPECT_EQ(to_text(ClockQoS()), "keep_last 1, best_effort, volatile");
  EXPECT_EQ(to_text(ActionStatusQoS()), "keep_last 1, reliable, transient_local");
  EXPECT_EQ(to_text(DynamicTransformQoS()), "keep_last 100, reliable, volatile");
  EXPECT_EQ(to_text(StaticTransformQoS()), "keep_last 1, reliable, transient_local");
  EXPECT_EQ(to_text(StaticTransformListenerQoS()), "keep_last 100, reliable, transient_local");
  EXPECT_EQ(to_text(BestAvailableQoS()),
            "keep_last 10, best_available, best_available, deadline best_available, liveliness best_available, lease "
            "best_available");
  EXPECT_EQ(to_text(SensorDataQoS(QoS(2))), "keep_last 2, best_effort, volatile");
}

TEST(Presets, are_found_by_rmws_names) {
  for (const auto& name : preset_names()) EXPECT_TRUE(preset(name).has_value()) << name;
  EXPECT_EQ(preset("sensor_data"), SensorDataQoS());
  EXPECT_FALSE(preset("sensor-data").has_value());
}

}  // namespace
}  // namespace nacelle
