// SPDX-License-Identifier: Apache-2.0
#include "loading/plan_json.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <nlohmann/json.hpp>

namespace nacelle::loading {
namespace {

launch::ComponentPlan plan_with_everything() {
  launch::ComponentPlan plan;
  plan.plugin = "a::B";
  plan.name = "b";
  plan.namespace_ = "/front";
  const std::vector<ParameterValue> values{
      std::monostate{},
      true,
      std::numeric_limits<std::int64_t>::min(),
      0.1,
      std::numeric_limits<double>::infinity(),
      std::string("text"),
      std::vector<std::uint8_t>{0, 255},
      std::vector<bool>{true, false},
      std::vector<std::int64_t>{1, -2},
      std::vector<double>{1e-300, -0.0},
      std::vector<std::string>{"", "x"},
  };
  for (std::size_t i = 0; i < values.size(); ++i) plan.parameters.push_back({"p" + std::to_string(i), values[i], {}});
  plan.remaps.push_back(parse_remap_rule("rostopic://scan:=/scan").value());
  launch::TopicQos qos;
  qos.topic = "/scan";
  qos.side = launch::Side::Publisher;
  qos.start = QoS(KeepAll{}).max_samples(7).deadline(20ms).best_effort();
  qos.patch.lifespan = 5ms;
  plan.qos.push_back(qos);
  plan.thread = {.own = true, .priority = 20, .cpus = {1, 3}, .threads = 2};
  return plan;
}

TEST(PlanJson, reads_back_as_the_same_plan) {
  const launch::ComponentPlan plan = plan_with_everything();
  const auto came = plan_from_json(nlohmann::json::parse(plan_to_json(plan).dump()));
  EXPECT_EQ(came.plugin + came.full_name(), plan.plugin + plan.full_name());
  ASSERT_EQ(came.parameters.size(), plan.parameters.size());
  for (std::size_t i = 0; i < plan.parameters.size(); ++i) {
    EXPECT_EQ(came.parameters[i].name, plan.parameters[i].name);
    EXPECT_EQ(came.parameters[i].value, plan.parameters[i].value) << i;
  }
  EXPECT_EQ(came.remaps, plan.remaps);
  EXPECT_EQ(came.thread, plan.thread);
  ASSERT_EQ(came.qos.size(), 1U);
  for (const QoS& in_code : {QoS(3), QoS(KeepAll{}).transient_local()})
    EXPECT_EQ(came.qos[0].applied_to(in_code), plan.qos[0].applied_to(in_code));
  EXPECT_EQ(came.qos[0].side, launch::Side::Publisher);
}

TEST(PlanJson, keeps_each_policy_that_a_launch_file_can_give) {
  const std::map<std::string, std::string> given{{"reliability", "best_effort"},
                                                 {"durability", "transient_local"},
                                                 {"history", "keep_all"},
                                                 {"depth", "3"},
                                                 {"deadline", "20ms"},
                                                 {"lifespan", "5ms"},
                                                 {"liveliness", "manual_by_topic"},
                                                 {"lease", "7ms"},
                                                 {"max_samples", "9"},
                                                 {"max_blocking_time", "1ms"},
                                                 {"when_dry", "fail"}};
  for (const auto& key : qos_keys()) {
    if (key == "profile") continue;
    ASSERT_TRUE(given.contains(key)) << key;
    launch::ComponentPlan plan = plan_with_everything();
    plan.qos[0].start.reset();
    plan.qos[0].patch = {};
    ASSERT_TRUE(set_policy(plan.qos[0].patch, key, given.at(key)));
    ASSERT_NE(plan.qos[0].applied_to(QoS(1)), QoS(1)) << key;
    const auto came = plan_from_json(nlohmann::json::parse(plan_to_json(plan).dump()));
    EXPECT_EQ(came.qos[0].applied_to(QoS(1)), plan.qos[0].applied_to(QoS(1))) << key;
  }
}

TEST(PlanJson, refuses_what_is_no_plan_with_an_exception) {
  nlohmann::json row = plan_to_json(plan_with_everything());
  row.erase("thread");
  EXPECT_THROW(static_cast<void>(plan_from_json(row)), std::exception);
  row = plan_to_json(plan_with_everything());
  row["parameters"][1]["is"]["type"] = 99;
  EXPECT_THROW(static_cast<void>(plan_from_json(row)), std::exception);
  row = plan_to_json(plan_with_everything());
  row["remaps"] = {"no rule"};
  EXPECT_THROW(static_cast<void>(plan_from_json(row)), std::exception);
}

}  // namespace
}  // namespace nacelle::loading
