// SPDX-License-Identifier: Apache-2.0
// What the filter says of its inputs: the service ~/status, and the parameters beside it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <diagnostic_msgs/srv/self_test.hpp>
#include "ekf/component/innovation_report.hpp"
#include "ekf_node.hpp"

namespace nacelle::ekf {
namespace {

using diagnostic_msgs::srv::SelfTest;

std::map<std::string, std::string> values_of(const diagnostic_msgs::msg::DiagnosticStatus& status) {
  std::map<std::string, std::string> values;
  for (const auto& pair : status.values) values[std::string{pair.key}] = std::string{pair.value};
  return values;
}

struct EkfStatus : EkfNode {
  SelfTest::Response ask() {
    SelfTest::Response response;
    EXPECT_TRUE(context_.call<SelfTest>("/ekf/status", {}, response));
    return response;
  }
  /// An IMU that is `factor` times as noisy as its covariance says (its stddev: the root of 3e-6).
  void run_noisy(double factor, int ticks) {
    const auto noise = [&] { return factor * std::sqrt(3e-6) * normal_(random_); };
    for (int i = 0; i < ticks; ++i) {
      context_.advance(9ms);
      send_imu(noise());
      context_.advance(9ms);
      send_imu(noise());
      send_odometry(0.3 + 0.01 * normal_(random_));
      context_.advance(2ms);
    }
  }
  std::mt19937 random_{76};
  std::normal_distribution<double> normal_;
};

TEST_F(EkfStatus, names_the_input_that_is_noisier_than_it_says) {
  options_.append_parameter_override("process_noise", std::string{"wheeled"});
  start();
  run_noisy(3.1, 400);
  const auto response = ask();
  EXPECT_EQ(response.passed, 1);
  ASSERT_EQ(response.status.size(), 2U);
  EXPECT_EQ(response.status[1].name, "ekf: imu0 angular_velocity");
  auto values = values_of(response.status[1]);
  EXPECT_THAT(
      values["sentence"],
      ::testing::MatchesRegex("imu0 angular_velocity\\.z is [23]\\.[0-9] times as noisy as its covariance says"));
  EXPECT_NEAR(std::stod(values["rate"]), 100.0, 15.0);
  EXPECT_NEAR(std::stod(values["delay"]), 0.0, 0.01);
  EXPECT_GT(std::stod(values["noise z"]), 2.0);
  EXPECT_EQ(values_of(response.status[0]).count("nis z"), 0U) << "two_d_mode holds it";
}

TEST_F(EkfStatus, is_there_without_print_diagnostics_and_before_the_first_measurement) {
  start();
  context_.advance(100ms);
  const auto response = ask();
  EXPECT_EQ(response.passed, 0);
  EXPECT_EQ(response.status.size(), 2U);
  EXPECT_TRUE(context_.published<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics").empty());
}

TEST_F(EkfStatus, shows_by_how_much_an_adaptive_input_is_raised) {
  options_.append_parameter_override("process_noise", std::string{"wheeled"});
  options_.append_parameter_override("odom0", std::string{"odom"});
  options_.append_parameter_override("odom0_config", config_of({kVx}));
  options_.append_parameter_override("imu0", std::string{"imu/data_raw"});
  options_.append_parameter_override("imu0_config", config_of({kVyaw}));
  options_.append_parameter_override("imu0_adaptive_measurement_noise", true);
  start();
  run_noisy(5.0, 400);
  const auto response = ask();
  ASSERT_EQ(response.status.size(), 2U);
  EXPECT_GT(std::stod(values_of(response.status[1])["scale z"]), 2.0);
  EXPECT_EQ(std::stod(values_of(response.status[0])["scale vx"]), 1.0);
}

TEST(InnovationReport, says_the_thing_to_mend_first) {
  EXPECT_EQ(finding_of({.count = 29, .nis = 50.0, .noise = 9.0}), "");
  EXPECT_EQ(finding_of({.count = 500, .nis = 1.1, .noise = 1.0}), "");
  EXPECT_EQ(finding_of({.count = 500, .nis = 0.0, .noise = 0.0}), "") << "wheels at rest";
  EXPECT_EQ(finding_of({.count = 500, .nis = 9.0, .offset = 0.1, .noise = 3.14}),
            "is 3.1 times as noisy as its covariance says");
  EXPECT_THAT(finding_of({.count = 500, .nis = 9.0, .noise = 3.14, .scale = 2.5}),
              ::testing::HasSubstr("takes it as 2.5 times"));
  EXPECT_THAT(finding_of({.count = 500, .nis = 16.0, .offset = -3.5, .noise = 1.0}),
              ::testing::HasSubstr("-3.5 standard deviations"));
  EXPECT_THAT(finding_of({.count = 500, .nis = 16.0, .offset = 0.0, .noise = 1.0}),
              ::testing::HasSubstr("too little process noise"));
  EXPECT_THAT(finding_of({.count = 500, .nis = 0.05, .noise = 0.2}), ::testing::HasSubstr("5.0 times as precise"));
  EXPECT_THAT(finding_of({.count = 500, .nis = 0.01, .noise = 1.0}), ::testing::HasSubstr("too much process noise"));
}

struct WheeledParameters : EkfNode {
  std::string refusal() {
    EkfComponent node{options_};
    return node.trigger(Transition::Configure).reason;
  }
};

TEST_F(WheeledParameters, make_a_stationary_filter_surer_than_the_default) {
  options_.append_parameter_override("process_noise", std::string{"wheeled"});
  options_.append_parameter_override("process_noise_limits.linear_velocity", 0.5);
  start();
  for (int i = 0; i < 200; ++i) run(0.0, 0.0);
  ASSERT_FALSE(filtered().empty());
  const double variance = filtered().back().pose.covariance[0];
  EXPECT_GT(variance, 1e-7);
  EXPECT_LT(variance, 1e-3) << "robot_localization's matrix gives 0.2 m^2 in 4 s";
}

TEST_F(WheeledParameters, refuse_another_word) {
  options_.append_parameter_override("process_noise", std::string{"tracked"});
  EXPECT_THAT(refusal(), ::testing::HasSubstr("process_noise"));
}

TEST_F(WheeledParameters, refuse_a_limit_of_zero) {
  options_.append_parameter_override("process_noise", std::string{"wheeled"});
  options_.append_parameter_override("process_noise_limits.linear_acceleration", 0.0);
  EXPECT_THAT(refusal(), ::testing::HasSubstr("process_noise_limits.linear_acceleration"));
}

TEST_F(WheeledParameters, refuse_two_matrices) {
  options_.append_parameter_override("process_noise", std::string{"wheeled"});
  options_.append_parameter_override("process_noise_covariance", std::vector<double>(15, 0.1));
  EXPECT_THAT(refusal(), ::testing::HasSubstr("process_noise_covariance"));
}

}  // namespace
}  // namespace nacelle::ekf
