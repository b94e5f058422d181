// SPDX-License-Identifier: Apache-2.0
// Built where libgpiod is not installed.
#include <utility>

#include "range/port/echo_lines.hpp"

namespace nacelle::range {

Result<std::unique_ptr<EchoLines>, Problem> request_echo_lines(const EchoSettings& settings, const Clock&) {
  Problem problem = explain_echo_lines(settings, 0);
  problem.what = "this program was built without libgpiod";
  problem.way_out = "install libgpiod-dev and build again";
  return err(std::move(problem));
}

}  // namespace nacelle::range
