// SPDX-License-Identifier: Apache-2.0
#include "report/filter_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "ask/filters.hpp"

namespace nacelle::report {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json pair(const char* key, const char* value) { return {{"key", key}, {"value", value}}; }

json answer() {
  return {{"id", "ekf"},
          {"passed", 1},
          {"status",
           {{{"name", "ekf: odom0 twist"},
             {"values",
              {pair("received", "512"), pair("fused", "500"), pair("lost", "2"), pair("rejected_gate", "12"),
               pair("rejected_stale", "0"), pair("rate", "49.98"), pair("delay", "0.004000"), pair("nis vx", "0.910"),
               pair("noise vx", "1.050"), pair("offset vx", "-0.100"), pair("scale vx", "1.000")}}},
            {{"name", "ekf: imu0 angular_velocity"},
             {"values",
              {pair("received", "1000"), pair("fused", "1000"), pair("nis z", "9.300"), pair("noise z", "3.100"),
               pair("offset z", "0.020"), pair("scale z", "2.500"),
               pair("sentence", "imu0 angular_velocity.z is 3.1 times as noisy as its covariance says")}}}}}};
}

TEST(FilterOf, reads_what_a_filter_says_of_its_inputs) {
  const json filter = ask::filter_of("/ekf", answer());
  EXPECT_EQ(filter["node"], "/ekf");
  EXPECT_EQ(filter["initialised"], true);
  ASSERT_EQ(filter["inputs"].size(), 2U);
  const json& odom = filter["inputs"][0];
  EXPECT_EQ(odom["name"], "odom0 twist");
  EXPECT_EQ(odom["fused"], 500);
  EXPECT_EQ(odom["lost"], 2);
  EXPECT_EQ(odom["rejected"], json({{"gate", 12}})) << "causes that did not occur are left out";
  EXPECT_DOUBLE_EQ(odom["rate_hz"], 49.98);
  EXPECT_DOUBLE_EQ(odom["delay_s"], 0.004);
  EXPECT_EQ(odom["axes"], json({{{"name", "vx"}, {"nis", 0.91}, {"noise", 1.05}, {"offset", -0.1}, {"scale", 1.0}}}));
  EXPECT_EQ(odom["sentence"], "");
}

TEST(FilterOf, takes_an_answer_that_lacks_everything) {
  const json filter = ask::filter_of("/ekf", json::object());
  EXPECT_EQ(filter["initialised"], false);
  EXPECT_TRUE(filter["inputs"].empty());
  const json odd = ask::filter_of("/ekf", {{"passed", "yes"}, {"status", {{{"name", 3}, {"values", {{{"key", 7}}}}}}}});
  EXPECT_EQ(odd["inputs"][0]["name"], "");
}

TEST(FiltersText, has_a_row_for_each_axis_and_a_sentence) {
  const std::string text = filters_text({{"filters", {ask::filter_of("/ekf", answer())}}});
  EXPECT_THAT(text, HasSubstr("/ekf\n"));
  EXPECT_THAT(text, HasSubstr("12 gate"));
  EXPECT_THAT(text, HasSubstr("3.10 (taken as 2.50)"));
  EXPECT_THAT(text, HasSubstr("imu0 angular_velocity.z is 3.1 times as noisy as its covariance says\n"));
  EXPECT_THAT(text, Not(HasSubstr("every input")));
}

TEST(FiltersText, says_that_nothing_is_odd_or_that_nothing_came) {
  json good = answer();
  good["status"].erase(1);
  EXPECT_THAT(filters_text({{"filters", {ask::filter_of("/ekf", good)}}}), HasSubstr("every input is as noisy as"));
  good["passed"] = 0;
  EXPECT_THAT(filters_text({{"filters", {ask::filter_of("/ekf", good)}}}), HasSubstr("waits for its first"));
}

}  // namespace
}  // namespace nacelle::report
