// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/gpio_lines.hpp"

#include <gtest/gtest.h>

#include <cerrno>

namespace nacelle::io {
namespace {

TEST(ExplainGpio, names_chip_and_lines) {
  EXPECT_EQ(explain_gpio({"/dev/gpiochip4", {17}}, ENOENT).text(),
            "GPIO line 17 of /dev/gpiochip4: no such chip; `gpioinfo` lists chips and lines");
  EXPECT_EQ(explain_gpio({"/dev/gpiochip4", {23, 24}}, EACCES).text(),
            "GPIO lines 23, 24 of /dev/gpiochip4: no permission to open the chip; `sudo usermod -aG gpio $USER`, then "
            "log in again");
}

TEST(ExplainGpio, has_a_sentence_for_each_refusal_of_the_kernel) {
  const auto what = [](int os_code) { return explain_gpio({"/dev/gpiochip0", {1}}, os_code).what; };
  EXPECT_EQ(what(EPERM), "no permission to open the chip");
  EXPECT_EQ(what(EBUSY), "in use by another program or driver");
  EXPECT_EQ(what(EINVAL), "the chip has no such line, or cannot do that with it");
  EXPECT_EQ(what(ENOTTY), "no GPIO chip, or one of a kernel before 5.10");
  EXPECT_EQ(what(ENOMEM), "cannot be used (Cannot allocate memory)");
}

TEST(GpioLines, a_chip_that_is_not_there_is_a_problem) {
  EXPECT_EQ(request_gpio_outputs({"/dev/no_such_gpiochip", {2, 3}}).error().what, "no such chip");
  EXPECT_EQ(request_gpio_inputs({"/dev/null", {2}}).error().what, "no GPIO chip, or one of a kernel before 5.10");
}

}  // namespace
}  // namespace nacelle::io
