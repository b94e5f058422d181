// SPDX-License-Identifier: Apache-2.0
// Built where libgpiod is not installed.
#include "estop/port/gpio_line.hpp"

namespace nacelle::estop {

std::string_view gpio_library() { return "no libgpiod"; }

Result<std::unique_ptr<RequestedLine>, Problem> request_line(const GpioSettings& settings) {
  Problem problem = explain_gpio(settings, 0);
  problem.what = "this program was built without libgpiod";
  problem.way_out = "install libgpiod-dev and build again";
  return err(std::move(problem));
}

}  // namespace nacelle::estop
