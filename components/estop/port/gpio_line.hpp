// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "estop/port/switch_port.hpp"
#include "nacelle/base/problem.hpp"

namespace nacelle::estop {

enum class Bias : std::uint8_t { PullUp, PullDown, None };

/// Where a button is wired to, and how.
///
/// The defaults are those of a button that opens its contact (NC) between the line and ground: pressed, or with a broken
/// wire, the pull-up makes the line high.
struct GpioSettings {
  std::string chip = "/dev/gpiochip0";
  unsigned line = 0;  ///< The offset on the chip; on a Raspberry Pi the BCM number.
  bool stops_when_high = true;
  Bias bias = Bias::PullUp;
};

/// What both versions of libgpiod give: a requested input line, as a descriptor that can be read when the line has changed.
class RequestedLine {
 public:
  virtual ~RequestedLine() = default;
  [[nodiscard]] virtual int descriptor() const = 0;
  /// 0, 1, or -1 when it cannot be read.
  [[nodiscard]] virtual int value() = 0;
  /// Takes one change out of the descriptor. False when that cannot be read.
  [[nodiscard]] virtual bool take_event() = 0;
};

/// Opens the line with the library that this was built with.
/// Errors: a Problem that names chip and line, and says what to do (rights, in use, no such chip, no libgpiod).
[[nodiscard]] Result<std::unique_ptr<RequestedLine>, Problem> request_line(const GpioSettings& settings);
/// "libgpiod 1", "libgpiod 2" or "no libgpiod"
[[nodiscard]] std::string_view gpio_library();
/// What errno of a failed request means.
[[nodiscard]] Problem explain_gpio(const GpioSettings& settings, int os_code);

/// A button on a line. Errors: those of request_line().
[[nodiscard]] Result<std::unique_ptr<SwitchPort>, Problem> open_gpio_switch(const GpioSettings& settings,
                                                                            const Clock& clock);
/// The same with a line that is there already.
[[nodiscard]] std::unique_ptr<SwitchPort> switch_on(std::unique_ptr<RequestedLine> line, bool stops_when_high,
                                                    const Clock& clock);

}  // namespace nacelle::estop
