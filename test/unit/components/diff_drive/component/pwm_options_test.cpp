// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/pwm_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "../port/pwm_tree.hpp"
#include "diff_drive/component/boards.hpp"
#include "diff_drive/component/diff_drive_component.hpp"
#include "support/recording_host.hpp"

namespace nacelle::diff_drive {
namespace {

using ::testing::HasSubstr;

DiffDriveOptions wired() {
  DiffDriveOptions options;
  options.hardware = "pwm";
  options.counts_per_turn = 1320;
  options.pwm.left_lines = {23, 24};
  options.pwm.right_lines = {25, 26};
  options.pwm.left_encoder_lines = {5, 6};
  options.pwm.right_encoder_lines = {16, 20};
  return options;
}

TEST(PwmOptions, pins_that_are_all_named_are_valid_and_the_lack_of_a_watchdog_is_told) {
  const auto setup = validated(wired(), "/base");
  ASSERT_TRUE(setup) << setup.error().text();
  ASSERT_EQ(setup.value().warnings.size(), 1U);
  EXPECT_THAT(setup.value().warnings[0], HasSubstr("PWM has no watchdog"));
  const BaseWiring wiring = wiring_of_board(wired());
  EXPECT_EQ(wiring.left.channel, 0);
  EXPECT_EQ(wiring.right.channel, 1);
  EXPECT_EQ(line_of_board(wired()), "/sys/class/pwm/pwmchip0");
}

TEST(PwmOptions, each_mistake_names_node_parameter_value_and_way_out) {
  struct Row {
    const char* parameter;
    const char* value;
    std::function<void(DiffDriveOptions&)> spoil;
  };
  const Row table[] = {
      {"counts_per_turn", "is not set", [](auto& o) { o.counts_per_turn = 0; }},
      {"left_channel", "64 is no channel", [](auto& o) { o.left_channel = 64; }},
      {"right_channel", "both wheels are on channel 0", [](auto& o) { o.right_channel = 0; }},
      {"pwm.left_lines", "0 GPIO lines", [](auto& o) { o.pwm.left_lines.clear(); }},
      {"pwm.right_lines", "3 GPIO lines", [](auto& o) { o.pwm.right_lines.push_back(9); }},
      {"pwm.right_lines", "-1 is no GPIO line", [](auto& o) { o.pwm.right_lines[1] = -1; }},
      {"pwm.right_lines", "line 24 has another use", [](auto& o) { o.pwm.right_lines[1] = 24; }},
      {"pwm.left_encoder_lines", "line 23 has another use", [](auto& o) { o.pwm.left_encoder_lines[1] = 23; }},
      {"pwm.left_encoder_lines", "3 GPIO lines", [](auto& o) { o.pwm.left_encoder_lines.push_back(9); }},
      {"pwm.right_encoder_lines", "two channels", [](auto& o) { o.pwm.right_encoder_lines.pop_back(); }},
      {"pwm.encoder", "'eyes' counts no encoders", [](auto& o) { o.pwm.encoder = "eyes"; }},
      {"pwm.left_counter", "no count", [](auto& o) { o.pwm.encoder = "counter"; }},
      {"pwm.chip", "no chip", [](auto& o) { o.pwm.chip.clear(); }},
      {"pwm.frequency", "1 is not in", [](auto& o) { o.pwm.frequency_hz = 1; }},
      {"pwm.min_duty", "0.5 is not below", [](auto& o) { o.pwm.min_duty = o.pwm.max_duty = 0.5; }},
      {"pwm.p", "nan is not in", [](auto& o) { o.pwm.p = std::numeric_limits<double>::quiet_NaN(); }},
      {"pwm.i", "no wheel would turn", [](auto& o) { o.pwm.p = o.pwm.i = 0; }},
  };
  for (const auto& row : table) {
    DiffDriveOptions options = wired();
    row.spoil(options);
    const auto setup = validated(options, "/base");
    ASSERT_FALSE(setup) << row.parameter;
    EXPECT_EQ(setup.error().where.node, "/base") << row.parameter;
    EXPECT_EQ(setup.error().where.parameter, row.parameter);
    EXPECT_THAT(setup.error().text(), HasSubstr(row.value));
    EXPECT_FALSE(setup.error().way_out.empty()) << row.parameter;
  }
}

TEST(PwmOptions, encoder_lines_do_not_matter_to_counters) {
  DiffDriveOptions options = wired();
  options.pwm.left_encoder_lines.clear();
  options.pwm.encoder = "counter";
  options.pwm.left_counter = "/sys/bus/counter/devices/counter0/count0";
  options.pwm.right_counter = "/sys/bus/counter/devices/counter1/count0";
  EXPECT_TRUE(validated(options, "/base"));
}

TEST(PwmOptions, the_component_reads_its_parameters_and_names_pins_that_are_not_there) {
  test::RecordingContext context;
  PwmTree tree;
  NodeOptions options{context};
  options.append_parameter_override("hardware", std::string("pwm"));
  options.append_parameter_override("counts_per_turn", 1320.0);
  options.append_parameter_override("pwm.chip", tree.chip());
  options.append_parameter_override("pwm.gpio_chip", std::string("/dev/no_gpiochip"));
  options.append_parameter_override("pwm.left_lines", std::vector<std::int64_t>{23, 24});
  options.append_parameter_override("pwm.right_lines", std::vector<std::int64_t>{25, 26});
  options.append_parameter_override("pwm.left_encoder_lines", std::vector<std::int64_t>{5, 6});
  options.append_parameter_override("pwm.right_encoder_lines", std::vector<std::int64_t>{16, 20});
  DiffDriveComponent drive{options};
  const auto outcome = drive.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_THAT(outcome.reason, HasSubstr("/diff_drive"));
  EXPECT_THAT(outcome.reason, HasSubstr("pwm.left_lines"));
  EXPECT_THAT(outcome.reason, HasSubstr("GPIO lines 23, 24, 25, 26 of /dev/no_gpiochip: no such chip"));
  EXPECT_EQ(outcome.state, StateId::Unconfigured);
  EXPECT_TRUE(context.safe_stop().empty());
}

}  // namespace
}  // namespace nacelle::diff_drive
