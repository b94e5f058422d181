// SPDX-License-Identifier: Apache-2.0
// Motors on pins: direction lines and the edges of encoders on a real kernel driver, gpio-sim. The PWM is a tree of files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "../unit/components/diff_drive/port/pwm_tree.hpp"
#include "diff_drive/component/diff_drive_component.hpp"
#include "in_machine.hpp"
#include "nacelle/io/gpio_lines.hpp"
#include "support/recording_host.hpp"

namespace nacelle::diff_drive {
namespace {

using test::read_word;
using test::write_file;
using ::testing::HasSubstr;

/// A chip of eight lines: IN1 and IN2 of two H-bridges, A and B of two encoders.
class RealPins : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("gpio");
    std::filesystem::create_directories(kBank);
    write_file(kBank + "/num_lines", "8");
    plug();
  }
  void TearDown() override {
    if (!test::in_machine("gpio")) return;
    std::filesystem::remove(kLink);
    if (read_word(kLive) == "1") write_file(kLive, "0");
    std::filesystem::remove(kBank);
    std::filesystem::remove(kDevice);
  }
  static void plug() {
    write_file(kLive, "1");
    std::filesystem::remove(kLink);
    std::filesystem::create_symlink("/dev/" + read_word(kBank + "/chip_name"), kLink);
  }
  static void unplug() { write_file(kLive, "0"); }
  static std::string line_file(unsigned line, const char* name) {
    return "/sys/devices/platform/" + read_word(kDevice + "/dev_name") + "/" + read_word(kBank + "/chip_name") +
           "/sim_gpio" + std::to_string(line) + "/" + name;
  }
  static std::string level(unsigned line) { return read_word(line_file(line, "value")); }
  static void pull(unsigned line, bool up) { write_file(line_file(line, "pull"), up ? "pull-up" : "pull-down"); }
  static io::GpioRequest request(std::vector<unsigned> lines) {
    io::GpioRequest wanted;
    wanted.chip = kLink;
    wanted.lines = std::move(lines);
    return wanted;
  }
  /// Waits for one edge, which comes a moment after the level has changed.
  io::GpioEdge next_edge(io::GpioInputs& inputs) {
    const MonotonicTime limit = clock_.now() + test::kPatience;
    while (clock_.now() < limit) {
      const auto edges = inputs.take();
      if (edges && edges->size() == 1) return edges->front();
      EXPECT_TRUE(edges && edges->empty());
    }
    ADD_FAILURE() << "no edge";
    return {};
  }

  static constexpr const char* kLink = "/dev/nacelle_pins";
  inline static const std::string kDevice = "/sys/kernel/config/gpio-sim/pins", kBank = kDevice + "/bank",
                                  kLive = kDevice + "/live";
  SystemClock clock_;
};

TEST_F(RealPins, outputs_are_low_from_their_request_on_and_follow) {
  const auto outputs = io::request_gpio_outputs(request({0, 1, 2, 3})).value();
  for (const unsigned line : {0U, 1U, 2U, 3U}) EXPECT_EQ(level(line), "0");
  ASSERT_TRUE(outputs->set(0b1001));
  EXPECT_EQ(level(0) + level(1) + level(2) + level(3), "1001");
  ASSERT_TRUE(outputs->set(0b0110));
  EXPECT_EQ(level(0) + level(1) + level(2) + level(3), "0110");
}

TEST_F(RealPins, edges_have_numbers_and_times_of_the_kernel) {
  const auto inputs = io::request_gpio_inputs(request({4, 5})).value();
  EXPECT_EQ(inputs->levels(), 0U);
  EXPECT_TRUE(inputs->take().value().empty());
  std::uint32_t numbers[2] = {}, sequence = 0;
  for (int turn = 0; turn < 20; ++turn) {
    for (const unsigned line : {0U, 1U}) {
      const MonotonicTime before = clock_.now();
      pull(4 + line, turn % 2 == 0);
      const io::GpioEdge edge = next_edge(*inputs);
      EXPECT_EQ(edge.line, line);
      EXPECT_EQ(edge.rising, turn % 2 == 0);
      EXPECT_EQ(edge.number, ++numbers[line]);
      EXPECT_EQ(edge.sequence, ++sequence);
      EXPECT_GE(edge.at, before);
      EXPECT_LE(edge.at, clock_.now());
    }
  }
  pull(5, true);
  static_cast<void>(next_edge(*inputs));
  EXPECT_EQ(inputs->levels(), 2U);
}

TEST_F(RealPins, edges_that_the_kernel_dropped_are_noticed) {
  auto inputs = io::request_gpio_inputs(request({4, 5})).value();
  EdgeEncoders encoders{std::move(inputs), false};
  WheelCount left, right;
  for (int edge = 0; edge < 4000; ++edge) pull(4, edge % 2 == 0);
  const MonotonicTime limit = clock_.now() + test::kPatience;
  while (encoders.stats().lost == 0 && clock_.now() < limit) {
    pull(4, true);
    pull(4, false);
    ASSERT_TRUE(encoders.read(left, right));
  }
  EXPECT_GT(encoders.stats().lost, 0U);
  EXPECT_GE(encoders.stats().edges, io::GpioInputs::kKept) << "what it kept";
  EXPECT_LT(encoders.stats().lost, 100'000U) << "more than there were";
  EXPECT_LT(std::abs(left.count), 100'000);
  EXPECT_EQ(right.count, 0);
  std::printf("%llu edges seen, %llu lost\n", static_cast<unsigned long long>(encoders.stats().edges),
              static_cast<unsigned long long>(encoders.stats().lost));
}

TEST_F(RealPins, a_chip_that_goes_is_noticed_and_comes_back) {
  const auto outputs = io::request_gpio_outputs(request({0, 1})).value();
  const auto inputs = io::request_gpio_inputs(request({4, 5})).value();
  unplug();
  EXPECT_FALSE(outputs->set(1));
  EXPECT_FALSE(inputs->take());
  EXPECT_FALSE(inputs->levels());
  EXPECT_FALSE(outputs->reopen());
  EXPECT_FALSE(inputs->reopen());
  plug();
  ASSERT_TRUE(outputs->reopen());
  ASSERT_TRUE(inputs->reopen());
  ASSERT_TRUE(outputs->set(1));
  EXPECT_EQ(level(0), "1");
  pull(4, true);
  EXPECT_EQ(next_edge(*inputs).number, 1U);
}

TEST_F(RealPins, distinguishes_lines_in_use_from_missing_ones) {
  const auto outputs = io::request_gpio_outputs(request({0, 1})).value();
  EXPECT_THAT(io::request_gpio_outputs(request({1, 2})).error().text(),
              HasSubstr("in use by another program or driver"));
  EXPECT_THAT(io::request_gpio_inputs(request({99})).error().text(), HasSubstr("no such line"));
  auto nowhere = request({1});
  nowhere.chip = "/dev/gpiochip77";
  EXPECT_THAT(io::request_gpio_inputs(nowhere).error().text(), HasSubstr("no such chip"));
}

/// The whole component: commands in, lines and PWM out, edges in, joint states out.
class RealPinsBase : public RealPins {
 protected:
  NodeOptions wired() {
    NodeOptions options{context_};
    const auto lines = [](std::int64_t first) { return std::vector<std::int64_t>{first, first + 1}; };
    options.append_parameter_override("hardware", std::string("pwm"));
    options.append_parameter_override("counts_per_turn", 40.0);
    options.append_parameter_override("pwm.chip", tree_.chip());
    options.append_parameter_override("pwm.gpio_chip", std::string(kLink));
    options.append_parameter_override("pwm.left_lines", lines(0));
    options.append_parameter_override("pwm.right_lines", lines(2));
    options.append_parameter_override("pwm.left_encoder_lines", lines(4));
    options.append_parameter_override("pwm.right_encoder_lines", lines(6));
    options.append_parameter_override("pwm.stall_timeout", 0.0);  // the wheels turn when the test says so
    options.append_parameter_override("cmd_vel_timeout", 60.0);
    options.append_parameter_override("rearm", std::string("fresh"));
    return options;
  }
  void command(double linear_mps, double angular_rps) {
    geometry_msgs::msg::Twist twist;
    twist.linear.x = linear_mps;
    twist.angular.z = angular_rps;
    context_.inject("/cmd_vel", twist);
  }
  /// Waits until the loop, which is a thread of its own, has made it so.
  bool becomes(const std::function<bool()>& is_so) {
    const MonotonicTime limit = clock_.now() + test::kPatience;
    while (!is_so()) {
      if (clock_.now() > limit) return false;
      static_cast<void>(context_.wait_for("/none", 1, 5ms));
    }
    return true;
  }
  static std::string lines() { return level(0) + level(1) + level(2) + level(3); }
  bool stands() {
    return becomes([&] { return lines() == "0000" && tree_.share(0) == 0.0 && tree_.share(1) == 0.0; });
  }

  PwmTree tree_;
  test::RecordingContext context_{clock_};
};

TEST_F(RealPinsBase, drives_counts_and_stops) {
  DiffDriveComponent base{wired()};
  const auto configured = base.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  EXPECT_EQ(context_.safe_stop(), (std::vector<std::uint8_t>{'0', '\n'}));
  EXPECT_EQ(context_.safe_stop_descriptors().size(), 2U) << "a frame for each wheel";
  ASSERT_TRUE(base.trigger(Transition::Activate).success);
  command(0.0, 2.0);
  EXPECT_TRUE(becomes([&] { return lines() == "0110" && tree_.share(0) > 0.0 && tree_.share(1) > 0.0; }));
  const auto edges_of = [&](std::size_t wheel) {
    const auto states = context_.published<sensor_msgs::msg::JointState>("/joint_states");
    return states.empty() ? 0.0 : states.back().position.at(wheel) * 40.0 / (2.0 * M_PI);
  };
  // The right wheel forward, the left one back, from the levels of the pull-ups. The kernel's handler must see each edge by itself.
  double edges = 0.0;
  for (int turn = 0; turn < 3; ++turn) {
    for (const bool up : {false, true}) {
      for (const unsigned line : {0U, 1U}) {
        edges += 1.0;
        pull(6 + line, up);
        ASSERT_TRUE(becomes([&] { return std::abs(edges_of(1) - edges) < 1e-6; })) << edges_of(1) << " of " << edges;
        pull(5 - line, up);
        ASSERT_TRUE(becomes([&] { return std::abs(edges_of(0) + edges) < 1e-6; })) << edges_of(0) << " of " << -edges;
      }
    }
  }
  std_msgs::msg::Bool stop;
  stop.data = true;
  context_.inject("/emergency_stop", stop);
  EXPECT_TRUE(stands());
  EXPECT_TRUE(base.trigger(Transition::Deactivate).success);
  EXPECT_TRUE(base.trigger(Transition::Cleanup).success);
  EXPECT_TRUE(context_.safe_stop_descriptors().empty());
  EXPECT_TRUE(context_.faults().empty());
}

TEST_F(RealPinsBase, a_chip_that_is_gone_stops_the_other_pins_and_is_taken_again) {
  DiffDriveComponent base{wired()};
  ASSERT_TRUE(base.trigger(Transition::Configure).success);
  ASSERT_TRUE(base.trigger(Transition::Activate).success);
  command(0.2, 0.0);
  ASSERT_TRUE(becomes([&] { return lines() == "1010"; }));
  unplug();
  context_.wait_for_open_faults(1);
  EXPECT_EQ(tree_.share(0), 0.0);
  EXPECT_EQ(tree_.share(1), 0.0);
  plug();
  EXPECT_TRUE(becomes([&] { return context_.closed_faults() == 1; }));
  command(0.2, 0.0);
  EXPECT_TRUE(becomes([&] { return lines() == "1010" && tree_.share(0) > 0.0; }));
  ASSERT_TRUE(base.trigger(Transition::Deactivate).success);
  EXPECT_TRUE(stands());
}

}  // namespace
}  // namespace nacelle::diff_drive
