// SPDX-License-Identifier: Apache-2.0
// The emergency button on a line of a real kernel driver: gpio-sim.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "estop/component/emergency_stop_component.hpp"
#include "in_machine.hpp"
#include "support/recording_host.hpp"

namespace nacelle::estop {
namespace {

using test::read_word;
using test::write_file;

/// A normally closed contact to ground: opened by a press. The pull-up is the one that the line was asked for with.
class RealLine : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("gpio");
    std::filesystem::create_directories(kBank);
    write_file(kBank + "/num_lines", "4");
    write_file(kLive, "1");
    settings_.chip = "/dev/" + chip();
    settings_.line = 0;
  }
  void TearDown() override {
    if (!test::in_machine("gpio")) return;
    std::filesystem::remove(kLink);
    if (read_word(kLive) == "1") write_file(kLive, "0");
    std::filesystem::remove(kBank);
    std::filesystem::remove(kDevice);
  }
  [[nodiscard]] static std::string chip() { return read_word(kBank + "/chip_name"); }
  static void point_to_chip() {
    std::filesystem::remove(kLink);
    std::filesystem::create_symlink("/dev/" + chip(), kLink);
  }
  /// What the world pulls the line to.
  static void pull(const std::string& where) {
    write_file("/sys/devices/platform/" + read_word(kDevice + "/dev_name") + "/" + chip() + "/sim_gpio0/pull", where);
  }
  static void press() { pull("pull-up"); }
  static void let_go() { pull("pull-down"); }
  std::unique_ptr<SwitchPort> open() {
    auto opened = open_gpio_switch(settings_, clock_);
    EXPECT_TRUE(opened) << opened.error().text();
    return opened ? std::move(opened).value() : nullptr;
  }

  static constexpr const char* kLink = "/dev/nacelle_button";
  inline static const std::string kDevice = "/sys/kernel/config/gpio-sim/nacelle", kBank = kDevice + "/bank",
                                  kLive = kDevice + "/live";
  SystemClock clock_;
  GpioSettings settings_;
};

TEST_F(RealLine, an_unwired_button_is_pressed) {
  const auto button = open();
  ASSERT_TRUE(button);
  EXPECT_TRUE(button->is_pressed().value()) << "the pull-up that was asked for";
  RecordProperty("library", std::string{gpio_library()});
  std::printf("%s\n", std::string{gpio_library()}.c_str());
}

TEST_F(RealLine, levels_and_edges_come_through) {
  const auto button = open();
  ASSERT_TRUE(button);
  let_go();
  EXPECT_TRUE(button->wait_until(clock_.now() + 5s).value());
  EXPECT_FALSE(button->is_pressed().value());
  EXPECT_FALSE(button->wait_until(clock_.now() + 20ms).value()) << "one edge, one event";
  press();
  EXPECT_TRUE(button->wait_until(clock_.now() + 5s).value());
  EXPECT_TRUE(button->is_pressed().value());
}

TEST_F(RealLine, reports_a_press_that_is_already_over) {
  const auto button = open();
  ASSERT_TRUE(button);
  let_go();
  ASSERT_TRUE(button->wait_until(clock_.now() + 5s).value());
  press();
  let_go();
  EXPECT_TRUE(button->wait_until(clock_.now() + 5s).value());
  EXPECT_FALSE(button->is_pressed().value());
}

TEST_F(RealLine, distinguishes_a_line_in_use_from_a_missing_one) {
  const auto button = open();
  ASSERT_TRUE(button);
  const auto second = open_gpio_switch(settings_, clock_);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().text(), ::testing::HasSubstr("in use by another program or driver"));
  settings_.line = 999;
  const auto no_line = open_gpio_switch(settings_, clock_);
  ASSERT_FALSE(no_line);
  EXPECT_THAT(no_line.error().text(), ::testing::HasSubstr("no such line"));
  settings_.chip = "/dev/gpiochip77";
  const auto no_chip = open_gpio_switch(settings_, clock_);
  ASSERT_FALSE(no_chip);
  EXPECT_THAT(no_chip.error().text(), ::testing::HasSubstr("no such chip"));
}

TEST_F(RealLine, the_component_sets_the_stop_when_it_is_pressed_and_when_the_chip_goes) {
  using std_msgs::msg::Bool;
  test::RecordingContext context{clock_};
  NodeOptions options{context};
  point_to_chip();
  options.append_parameter_override("gpio_chip", std::string{kLink});
  EmergencyStopComponent stop{options};
  const auto configured = stop.trigger(Transition::Configure);
  ASSERT_TRUE(configured.success) << configured.reason;
  let_go();
  ASSERT_TRUE(stop.trigger(Transition::Activate).success);
  EXPECT_FALSE(context.wait_for("/emergency_stop", 1, 300ms) && !context.published<Bool>("/emergency_stop")[0].data);
  const std::size_t before = context.published<Bool>("/emergency_stop").size();

  const MonotonicTime pressed_at = clock_.now();
  press();
  ASSERT_TRUE(context.wait_for("/emergency_stop", before + 1));
  const Duration took = clock_.now() - pressed_at;
  EXPECT_TRUE(context.published<Bool>("/emergency_stop").back().data);
  std::printf("press to emergency_stop: %.2f ms\n", to_milliseconds(took));
  let_go();

  write_file(kLive, "0");
  context.wait_for_open_faults(1);
  ASSERT_EQ(context.open_faults().size(), 1U) << "the chip is gone, and the component does not report it";
  EXPECT_TRUE(context.published<Bool>("/emergency_stop").back().data);
  EXPECT_TRUE(context.faults().empty());

  // It reappears under a number of the kernel's choice, and a link of udev's follows it.
  write_file(kLive, "1");
  point_to_chip();
  const MonotonicTime limit = clock_.now() + 10s;
  while (context.closed_faults() == 0 && clock_.now() < limit)
    static_cast<void>(context.wait_for("/emergency_stop", 9999, 20ms));
  EXPECT_EQ(context.closed_faults(), 1U) << "the chip is back";
}

}  // namespace
}  // namespace nacelle::estop
