// SPDX-License-Identifier: Apache-2.0
#include "pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "drawing/chart.hpp"

namespace nacelle::ekf::honesty {
namespace {

using drawing::Chart;
using drawing::ChartLine;

constexpr double kWindow_s = 10.0, kNormal95 = 1.96;
constexpr double kTrackPoints = 500.0;

bool write(const std::string& path, const Chart& chart) {
  std::ofstream out{path};
  out << drawing::chart_svg(chart);
  if (out.good()) return true;
  std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
  return false;
}

Chart track_of(const std::vector<Estimate>& estimates) {
  Chart chart{"x, m", "y, m", {{"truth", {}}, {"estimate", {}}}, true, false};
  double next_s = 0.0;
  const double every_s = (estimates.back().truth.t_s - estimates.front().truth.t_s) / kTrackPoints;
  for (const Estimate& e : estimates) {
    if (e.truth.t_s < next_s) continue;
    next_s = e.truth.t_s + every_s;
    chart.lines[0].points.push_back({e.truth.x_m, e.truth.y_m});
    chart.lines[1].points.push_back({e.x_m, e.y_m});
  }
  return chart;
}

}  // namespace

bool draw(const std::string& folder, const Drive& drive, const Setup& setup) {
  const std::vector<Estimate> estimates = run(drive, setup);
  if (estimates.empty() || !write(folder + "/track.svg", track_of(estimates))) return false;
  Chart across{
      "t, s", "error after 10 s across the track, m", {{"error", {}}, {"+95 %", {}}, {"-95 %", {}}}, false, false};
  Chart yaw = across;
  yaw.y_label = "error after 10 s of the yaw, deg";
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const auto add = [](Chart& chart, double t_s, double error, double variance, double unit) {
    const double limit = kNormal95 * std::sqrt(variance);
    chart.lines[0].points.push_back({t_s, unit * error});
    chart.lines[1].points.push_back({t_s, unit * limit});
    chart.lines[2].points.push_back({t_s, -unit * limit});
  };
  // Windows that overlap: a curve instead of a dot for each.
  const double end_s = drive.truth.back().t_s, step_s = std::max(1.0, end_s / 300.0);
  for (double begin_s = drive.truth.front().t_s; begin_s + 1.0 + kWindow_s <= end_s; begin_s += step_s) {
    const auto window = run(drive, setup, begin_s, begin_s + 1.0 + kWindow_s);
    const Estimate* begin = nullptr;
    for (const Estimate& e : window) {
      if (begin == nullptr && e.truth.t_s >= begin_s + 1.0) begin = &e;
    }
    if (begin == nullptr) continue;
    const Motion m = motion_between(*begin, window.back());
    add(across, begin_s + 1.0 + kWindow_s, m.error[1], m.covariance[1][1], 1.0);
    add(yaw, begin_s + 1.0 + kWindow_s, m.error[2], m.covariance[2][2], kDegrees);
  }
  return write(folder + "/position_error.svg", across) && write(folder + "/yaw_error.svg", yaw);
}

}  // namespace nacelle::ekf::honesty
