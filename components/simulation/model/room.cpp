// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/room.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nacelle::simulation {
namespace {

void add_box(std::vector<Segment>& walls, double x0, double y0, double x1, double y1) {
  walls.push_back({x0, y0, x1, y0});
  walls.push_back({x1, y0, x1, y1});
  walls.push_back({x1, y1, x0, y1});
  walls.push_back({x0, y1, x0, y0});
}

}  // namespace

Room Room::with_two_boxes() {
  std::vector<Segment> walls;
  add_box(walls, -2.0, -2.0, 2.0, 2.0);
  add_box(walls, -1.5, 0.9, -1.1, 1.3);
  add_box(walls, 1.2, -1.5, 1.7, -1.1);
  return Room{std::move(walls)};
}

double Room::range_m(double x_m, double y_m, double direction_rad) const {
  const double dx = std::cos(direction_rad), dy = std::sin(direction_rad);
  double nearest = std::numeric_limits<double>::infinity();
  for (const Segment& wall : walls_) {
    // p + t d = a + s (b - a), solved with two-dimensional cross products.
    const double wx = wall.x1_m - wall.x0_m, wy = wall.y1_m - wall.y0_m;
    const double across = dx * wy - dy * wx;
    if (std::abs(across) < 1e-12) continue;  // parallel: seen edge on, it has no width
    const double ax = wall.x0_m - x_m, ay = wall.y0_m - y_m;
    const double t = (ax * wy - ay * wx) / across;
    const double s = (ax * dy - ay * dx) / across;
    if (t > 0.0 && s >= 0.0 && s <= 1.0) nearest = std::min(nearest, t);
  }
  return nearest;
}

double Room::clearance_m(double x_m, double y_m) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Segment& wall : walls_) {
    const double wx = wall.x1_m - wall.x0_m, wy = wall.y1_m - wall.y0_m;
    const double length2 = wx * wx + wy * wy;
    const double along = length2 > 0.0 ? ((x_m - wall.x0_m) * wx + (y_m - wall.y0_m) * wy) / length2 : 0.0;
    const double s = std::clamp(along, 0.0, 1.0);
    nearest = std::min(nearest, std::hypot(wall.x0_m + s * wx - x_m, wall.y0_m + s * wy - y_m));
  }
  return nearest;
}

}  // namespace nacelle::simulation
