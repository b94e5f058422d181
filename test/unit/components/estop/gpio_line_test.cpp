// SPDX-License-Identifier: Apache-2.0
#include "estop/port/gpio_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>

#include "nacelle/io/descriptor.hpp"

namespace nacelle::estop {
namespace {

using ::testing::HasSubstr;

/// A line whose changes come through an eventfd, as those of the kernel through its descriptor.
class FakeLine final : public RequestedLine {
 public:
  explicit FakeLine(int& level) : level_(level) {}
  int descriptor() const override { return events_.number(); }
  int value() override { return level_; }
  bool take_event() override {
    std::uint64_t count = 0;
    return ::read(events_.number(), &count, sizeof count) == sizeof count;
  }
  void change() {
    const std::uint64_t one = 1;
    ASSERT_EQ(::write(events_.number(), &one, sizeof one), static_cast<ssize_t>(sizeof one));
  }

 private:
  int& level_;
  io::Descriptor events_{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
};

TEST(GpioSwitch, is_pressed_at_the_level_that_stops) {
  const SystemClock clock;
  int level = 0;
  const auto opens = switch_on(std::make_unique<FakeLine>(level), true, clock);
  const auto closes = switch_on(std::make_unique<FakeLine>(level), false, clock);
  EXPECT_FALSE(opens->is_pressed().value());
  EXPECT_TRUE(closes->is_pressed().value());
  level = 1;
  EXPECT_TRUE(opens->is_pressed().value());
  EXPECT_FALSE(closes->is_pressed().value());
}

TEST(GpioSwitch, a_line_that_cannot_be_read_is_lost) {
  const SystemClock clock;
  int level = -1;
  const auto button = switch_on(std::make_unique<FakeLine>(level), true, clock);
  ASSERT_FALSE(button->is_pressed());
  EXPECT_EQ(button->is_pressed().error(), SwitchFault::Lost);
}

TEST(GpioSwitch, a_change_and_an_interrupt_end_a_wait) {
  const SystemClock clock;
  int level = 0;
  auto line = std::make_unique<FakeLine>(level);
  FakeLine& wire = *line;
  const auto button = switch_on(std::move(line), true, clock);
  wire.change();
  EXPECT_TRUE(button->wait_until(clock.now() + 1h));
  button->interrupt();
  EXPECT_TRUE(button->wait_until(clock.now() + 1h));
}

TEST(GpioLine, a_chip_that_is_not_there_is_named_with_the_way_out) {
  GpioSettings settings;
  settings.chip = "/dev/no_such_gpiochip";
  settings.line = 17;
  const auto line = request_line(settings);
  ASSERT_FALSE(line);
  EXPECT_THAT(line.error().where.text(), HasSubstr("/dev/no_such_gpiochip"));
  EXPECT_THAT(line.error().where.text(), HasSubstr("17"));
  EXPECT_FALSE(line.error().way_out.empty()) << gpio_library();
}

TEST(GpioLine, each_refusal_of_the_kernel_has_its_way_out) {
  EXPECT_THAT(explain_gpio({}, EACCES).way_out, HasSubstr("usermod -aG gpio"));
  EXPECT_THAT(explain_gpio({}, EBUSY).what, HasSubstr("in use"));
  EXPECT_THAT(explain_gpio({}, EINVAL).what, HasSubstr("no such line"));
}

}  // namespace
}  // namespace nacelle::estop
