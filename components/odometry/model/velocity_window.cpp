// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/velocity_window.hpp"

#include <algorithm>

#include "nacelle/base/expect.hpp"

namespace nacelle::odometry {

VelocityWindow::VelocityWindow(std::size_t steps) : steps_(steps) {
  NACELLE_EXPECT(steps > 0, "a window holds one step or more");
}

void VelocityWindow::add(double distance_m, double turn_rad, double dt_s) {
  steps_[next_] = {distance_m, turn_rad, dt_s};
  next_ = (next_ + 1) % steps_.size();
  used_ = std::min(used_ + 1, steps_.size());
  // Recomputed, because a running sum would accumulate rounding errors.
  sum_ = {};
  for (std::size_t i = 0; i < used_; ++i) {
    sum_.distance_m += steps_[i].distance_m;
    sum_.turn_rad += steps_[i].turn_rad;
    sum_.dt_s += steps_[i].dt_s;
  }
}

void VelocityWindow::clear() {
  next_ = used_ = 0;
  sum_ = {};
}

}  // namespace nacelle::odometry
