// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace nacelle::odometry {

/// The mean velocity over the last few steps: their distance divided by their duration.
/// Threads: one. Allocates: in the constructor only.
class VelocityWindow {
 public:
  explicit VelocityWindow(std::size_t steps);

  void add(double distance_m, double turn_rad, double dt_s);
  void clear();
  /// 0 while empty.
  [[nodiscard]] double speed_mps() const { return sum_.dt_s > 0.0 ? sum_.distance_m / sum_.dt_s : 0.0; }
  [[nodiscard]] double yaw_rate_rps() const { return sum_.dt_s > 0.0 ? sum_.turn_rad / sum_.dt_s : 0.0; }
  [[nodiscard]] double duration_s() const { return sum_.dt_s; }

 private:
  struct Step {
    double distance_m{}, turn_rad{}, dt_s{};
  };
  std::vector<Step> steps_;  // a ring
  std::size_t next_{0};
  std::size_t used_{0};
  Step sum_;
};

}  // namespace nacelle::odometry
