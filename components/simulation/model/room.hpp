// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace nacelle::simulation {

/// A wall seen from above. Units: m. Frame: world (x east, y north).
struct Segment {
  double x0_m, y0_m, x1_m, y1_m;
};

/// Walls and boxes around the robot.
class Room {
 public:
  explicit Room(std::vector<Segment> walls) : walls_(std::move(walls)) {}
  /// 4 m x 4 m around the origin, with two boxes that leave the square (0,0) to (1,1) free by 0.8 m.
  [[nodiscard]] static Room with_two_boxes();

  /// Distance to the first wall from a point in a direction, or infinity.
  [[nodiscard]] double range_m(double x_m, double y_m, double direction_rad) const;
  /// Distance to the nearest wall in any direction.
  [[nodiscard]] double clearance_m(double x_m, double y_m) const;
  [[nodiscard]] const std::vector<Segment>& walls() const { return walls_; }

 private:
  std::vector<Segment> walls_;
};

}  // namespace nacelle::simulation
