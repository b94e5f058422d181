// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/waveshare_command.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "diff_drive/protocol/flat_json.hpp"

namespace nacelle::diff_drive {
namespace {

std::string speeds(double left, double right) {
  WaveshareCommandPrinter printer;
  return std::string(as_text(printer.wheel_speeds(left, right).value()));
}

TEST(WaveshareCommand, what_is_printed_reads_back_within_half_a_tenth_of_a_millimetre_per_second) {
  const unsigned seed = 41;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> speed{-2.0, 2.0};
  WaveshareCommandPrinter printer;
  for (int i = 0; i < 2000; ++i) {
    const double left = speed(random), right = speed(random);
    const std::string line{as_text(printer.wheel_speeds(left, right).value())};
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", case " << i << ": " << line);

    ASSERT_EQ(line.back(), '\n');
    FlatJsonReader json{line};
    const auto type = json.next(), l = json.next(), r = json.next();
    ASSERT_TRUE(type && l && r);
    EXPECT_FALSE(json.next());
    EXPECT_FALSE(json.failed());
    EXPECT_EQ(type->number, 1.0);
    EXPECT_NEAR(*l->number, left, 0.5e-4 + 1e-12);
    EXPECT_NEAR(*r->number, right, 0.5e-4 + 1e-12);
  }
}

TEST(WaveshareCommand, prints_these_lines) {
  EXPECT_EQ(speeds(0.5, -0.25), "{\"T\":1,\"L\":0.5,\"R\":-0.25}\n");
  EXPECT_EQ(speeds(2.0, -2.0), "{\"T\":1,\"L\":2,\"R\":-2}\n");
  EXPECT_EQ(speeds(0.0001, -0.0309), "{\"T\":1,\"L\":0.0001,\"R\":-0.0309}\n");
  EXPECT_EQ(speeds(1.99999, -1.9999), "{\"T\":1,\"L\":2,\"R\":-1.9999}\n");
  EXPECT_EQ(speeds(-0.00004, -0.0), "{\"T\":1,\"L\":0,\"R\":0}\n");
  WaveshareCommandPrinter printer;
  EXPECT_EQ(as_text(printer.motor_watchdog(std::chrono::milliseconds{500})), "{\"T\":136,\"cmd\":500}\n");
  EXPECT_EQ(as_text(printer.continuous_feedback(true)), "{\"T\":131,\"cmd\":1}\n");
  EXPECT_EQ(as_text(printer.feedback_delay(std::chrono::milliseconds{0})), "{\"T\":142,\"cmd\":0}\n");
  EXPECT_EQ(as_text(printer.echo(false)), "{\"T\":143,\"cmd\":0}\n");
}

TEST(WaveshareCommand, the_prepared_stop_frame_is_the_zero_command) {
  EXPECT_EQ(as_text(kWaveshareStopFrame), "{\"T\":1,\"L\":0,\"R\":0}\n");
  EXPECT_EQ(as_text(kWaveshareStopFrame), speeds(0.0, 0.0));
}

TEST(WaveshareCommand, refuses_what_the_board_would_ignore) {
  WaveshareCommandPrinter printer;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(printer.wheel_speeds(nan, 0).error(), SpeedCommandFault::NotFinite);
  EXPECT_EQ(printer.wheel_speeds(0, -std::numeric_limits<double>::infinity()).error(), SpeedCommandFault::NotFinite);
  EXPECT_EQ(printer.wheel_speeds(2.0001, 0).error(), SpeedCommandFault::TooFast);
  EXPECT_EQ(printer.wheel_speeds(0, -2.0001).error(), SpeedCommandFault::TooFast);
}

}  // namespace
}  // namespace nacelle::diff_drive
