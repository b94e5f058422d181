// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/ugv_device.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace nacelle::simulation {
namespace {

TEST(UgvLineReader, reads_the_makers_commands) {
  const auto speed = UgvLineReader::parse(R"({"T":1,"L":0.5,"R":-0.25})");
  ASSERT_TRUE(speed);
  EXPECT_EQ(speed->type, 1);
  EXPECT_DOUBLE_EQ(*speed->left, 0.5);
  EXPECT_DOUBLE_EQ(*speed->right, -0.25);
  const auto body = UgvLineReader::parse(R"({"T":13,"X":0.1,"Z":0.3})");
  ASSERT_TRUE(body);
  EXPECT_DOUBLE_EQ(*body->x, 0.1);
  EXPECT_DOUBLE_EQ(*body->z, 0.3);
  const auto flow = UgvLineReader::parse("{\"T\":131,\"cmd\":1}\r");
  ASSERT_TRUE(flow);
  EXPECT_DOUBLE_EQ(*flow->cmd, 1.0);
}

TEST(UgvLineReader, refuses_what_is_no_command) {
  for (const char* line : {"", "{}", "[1]", "17", "{\"T\":\"1\"}", "{\"T\":1e99}", "{\"T\":1,", "{\"T\":1}{\"T\":1}"}) {
    EXPECT_FALSE(UgvLineReader::parse(line)) << line;
  }
  EXPECT_FALSE(UgvLineReader::parse(R"({"T":1,"L":"fast","R":null})")->left);
}

TEST(UgvLineReader, counts_every_line_of_any_bytes) {
  const unsigned seed = 130;
  std::mt19937 random{seed};
  UgvLineReader reader;
  std::uint64_t commands = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::uint32_t draw = random() % 40;
    const std::uint8_t byte = draw == 0 ? '\n' : static_cast<std::uint8_t>("{\"T\":1,[]}LRXZ0.e-+ntf"[draw % 22]);
    reader.feed({&byte, 1}, [&](const UgvCommand&, std::string_view) { ++commands; });
  }
  reader.feed(as_bytes("\n{\"T\":130}\n"), [&](const UgvCommand&, std::string_view) { ++commands; });
  EXPECT_EQ(reader.stats().lines, reader.stats().commands + reader.stats().bad_lines) << "seed " << seed;
  EXPECT_EQ(reader.stats().commands, commands);
  EXPECT_GE(commands, 1U);
}

TEST(UgvLineReader, loses_a_line_longer_than_the_boards_buffer_and_only_that) {
  UgvLineReader reader;
  int commands = 0;
  const std::string padded = "{\"T\":1," + std::string(300, ' ') + "\"L\":1,\"R\":1}\n{\"T\":130}\n";
  reader.feed(as_bytes(padded), [&](const UgvCommand& command, std::string_view) {
    ++commands;
    EXPECT_EQ(command.type, 130);
  });
  EXPECT_EQ(commands, 1);
  EXPECT_EQ(reader.stats().bad_lines, 1U);
}

TEST(UgvFeedback, has_the_fields_of_the_firmware_in_its_order) {
  UgvFeedback feedback;
  feedback.left_mps = 0.1;
  feedback.odometry_left_m = 1.234567;
  feedback.odometry_right_m = -0.000144;
  EXPECT_EQ(print_feedback(feedback),
            "{\"T\":1001,\"L\":0.1,\"R\":0,\"r\":0,\"p\":0,\"y\":0,\"q0\":1,\"q1\":0,\"q2\":0,\"q3\":0,\"ax\":0,\"ay\":"
            "0,\"az\":1000,"
            "\"gx\":0,\"gy\":0,\"gz\":0,\"odl\":1.234567,\"odr\":-0.000144,\"v\":12}\r\n");
}

}  // namespace
}  // namespace nacelle::simulation
