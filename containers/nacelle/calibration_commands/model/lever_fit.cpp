// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/lever_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <optional>

namespace nacelle::calibration {
namespace {

constexpr double kWindow_s = 0.5;
constexpr double kHalfSpeed_s = 0.1;  // the speed is a difference of the way over twice this
constexpr double kMostGap_s = 0.1;
constexpr std::size_t kLeastWindows = 16;
constexpr double kLeastTurn_rad = 2.0 * std::numbers::pi, kLeastRate_rps = 0.3, kLeastShare = 0.25;
constexpr double kLeastAcceleration_mps2 = 0.05;
constexpr double kMostRateMismatch = 0.3, kLeastScale = 0.6, kMostScale = 1.4;
constexpr double kMostYaw_rad = 0.25 * std::numbers::pi / 180.0, kMostLever_m = 0.005;
constexpr double kOutlier = 4.0;
constexpr int kRounds = 3;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Rows = Eigen::Matrix<double, 2, 6>;

/// Linear between the entries of a series; nothing beyond its ends and in gaps.
template <typename Entry, typename Value>
std::optional<double> at(const std::vector<Entry>& series, double t, Value value) {
  const auto next =
      std::lower_bound(series.begin(), series.end(), t, [](const Entry& entry, double s) { return entry.stamp_s < s; });
  if (next == series.end()) return std::nullopt;
  if (next->stamp_s == t) return value(*next);
  if (next == series.begin()) return std::nullopt;
  const Entry& last = *std::prev(next);
  const double span = next->stamp_s - last.stamp_s;
  if (span > kMostGap_s) return std::nullopt;
  const double share = (t - last.stamp_s) / span;
  return value(last) + share * (value(*next) - value(last));
}

std::optional<double> slope(const std::vector<Progress>& wheels, double t, double Progress::*of) {
  const auto value = [of](const Progress& p) { return p.*of; };
  const auto before = at(wheels, t - kHalfSpeed_s, value), after = at(wheels, t + kHalfSpeed_s, value);
  if (!before || !after) return std::nullopt;
  return (*after - *before) / (2.0 * kHalfSpeed_s);
}

/// The means over a window.
struct Window {
  double x_mps2 = 0.0, y_mps2 = 0.0;             // measured
  double forward_mps2 = 0.0, inward_mps2 = 0.0;  // of the wheels: v', v w
  double alpha_rps2 = 0.0, square_rps2 = 0.0;    // of the gyro: w', w^2
  double gyro_rps = 0.0, wheels_rps = 0.0;
};

std::optional<Window> window_at(const std::vector<PlanarReading>& readings, const std::vector<Progress>& wheels,
                                double begin) {
  const double end = begin + kWindow_s;
  const auto rate = [](const PlanarReading& r) { return r.yaw_rate_rps; };
  const auto x = [](const PlanarReading& r) { return r.x_mps2; };
  const auto y = [](const PlanarReading& r) { return r.y_mps2; };
  std::vector<double> times{begin};
  for (auto it = std::upper_bound(readings.begin(), readings.end(), begin,
                                  [](double s, const PlanarReading&r) { return s < r.stamp_s; });
       it != readings.end() && it->stamp_s < end; ++it)
    times.push_back(it->stamp_s);
  times.push_back(end);
  Window w;
  double last_t = begin;
  std::optional<Vector6> last;
  std::optional<double> first_v, last_v, first_w, last_w;
  for (const double t : times) {
    const auto v = slope(wheels, t, &Progress::distance_m), by_wheels = slope(wheels, t, &Progress::yaw_rad);
    const auto w_t = at(readings, t, rate), x_t = at(readings, t, x), y_t = at(readings, t, y);
    if (!v || !by_wheels || !w_t || !x_t || !y_t) return std::nullopt;
    Vector6 now;
    now << *x_t, *y_t, *v * *w_t, *w_t * *w_t, *w_t, *by_wheels;
    if (last) {
      const Vector6 part = (t - last_t) / kWindow_s * 0.5 * (now + *last);
      w.x_mps2 += part[0];
      w.y_mps2 += part[1];
      w.inward_mps2 += part[2];
      w.square_rps2 += part[3];
      w.gyro_rps += part[4];
      w.wheels_rps += part[5];
    } else {
      first_v = v;
      first_w = w_t;
    }
    last = now;
    last_t = t;
    last_v = v;
    last_w = w_t;
  }
  w.forward_mps2 = (*last_v - *first_v) / kWindow_s;
  w.alpha_rps2 = (*last_w - *first_w) / kWindow_s;
  return w;
}

/// Unknowns: cos, sin, lever arm along the IMU's axes, bias.
Rows rows_of(const Window& w) {
  Rows rows;
  rows << w.forward_mps2, w.inward_mps2, -w.square_rps2, -w.alpha_rps2, 1.0, 0.0,  //
      w.inward_mps2, -w.forward_mps2, w.alpha_rps2, -w.square_rps2, 0.0, 1.0;
  return rows;
}

struct Solution {
  Vector6 unknowns = Vector6::Zero();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double variance = 0.0;
};

Solution solve(const std::vector<Window>& windows) {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Vector6 pull = Vector6::Zero();
  for (const auto& w : windows) {
    const Rows rows = rows_of(w);
    information += rows.transpose() * rows;
    pull += rows.transpose() * Eigen::Vector2d{w.x_mps2, w.y_mps2};
  }
  Solution solution;
  solution.unknowns = information.ldlt().solve(pull);
  double squares = 0.0;
  for (const auto& w : windows)
    squares += (Eigen::Vector2d{w.x_mps2, w.y_mps2} - rows_of(w) * solution.unknowns).squaredNorm();
  solution.variance = squares / (2.0 * static_cast<double>(windows.size()) - 6.0);
  solution.covariance = solution.variance * information.inverse();
  return solution;
}

/// The larger of both components of what a solution leaves of a window.
double off_by(const Window& w, const Solution& solution) {
  const Eigen::Vector2d off = Eigen::Vector2d{w.x_mps2, w.y_mps2} - rows_of(w) * solution.unknowns;
  return off.cwiseAbs().maxCoeff();
}

/// The standard deviation of most windows: a few bumps do not change the median. Source: the median of the larger of two normal
/// absolute values is 1.0518 standard deviations.
double scatter_of(const std::vector<Window>& windows, const Solution& solution) {
  std::vector<double> off;
  for (const auto& w : windows) off.push_back(off_by(w, solution));
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return *middle / 1.0518;
}

/// What the drive lacks, whatever the accelerometer says.
std::optional<LeverFault> lack_of(const std::vector<Window>& windows) {
  double left = 0.0, right = 0.0, fastest = 0.0, both = 0.0, squares = 0.0, accelerations = 0.0;
  for (const auto& w : windows) {
    (w.gyro_rps > 0.0 ? left : right) += std::abs(w.gyro_rps) * kWindow_s;
    fastest = std::max(fastest, std::abs(w.gyro_rps));
    both += w.gyro_rps * w.wheels_rps;
    squares += w.wheels_rps * w.wheels_rps;
    accelerations +=
        (w.forward_mps2 * w.forward_mps2 + w.inward_mps2 * w.inward_mps2) / static_cast<double>(windows.size());
  }
  const double turned_by_wheels = std::sqrt(squares / static_cast<double>(windows.size()));
  if (turned_by_wheels > 0.1 && std::abs(both / squares - 1.0) > kMostRateMismatch) return LeverFault::GyroDisagrees;
  if (left + right < kLeastTurn_rad || fastest < kLeastRate_rps) return LeverFault::HardlyTurned;
  if (std::min(left, right) < kLeastShare * std::max(left, right)) return LeverFault::OneWay;
  if (std::sqrt(accelerations) < kLeastAcceleration_mps2) return LeverFault::HardlyDriven;
  return std::nullopt;
}

}  // namespace

bool LeverFit::is_sure() const {
  return yaw_stddev_rad <= kMostYaw_rad && std::max(x_stddev_m, y_stddev_m) <= kMostLever_m;
}

Result<LeverFit, LeverFault> fit_lever(const std::vector<PlanarReading>& readings,
                                       const std::vector<Progress>& wheels) {
  std::vector<Window> windows;
  if (!readings.empty()) {
    for (double t = readings.front().stamp_s; t + kWindow_s <= readings.back().stamp_s; t += kWindow_s) {
      if (const auto window = window_at(readings, wheels, t)) windows.push_back(*window);
    }
  }
  if (windows.size() < kLeastWindows) return err(LeverFault::TooFew);
  if (const auto lack = lack_of(windows)) return err(*lack);
  Solution found = solve(windows);
  for (int round = 0; round < kRounds; ++round) {
    const double most = kOutlier * scatter_of(windows, found);
    std::erase_if(windows, [&](const Window& w) { return off_by(w, found) > most; });
    if (windows.size() < kLeastWindows) return err(LeverFault::Mismatch);
    found = solve(windows);
  }
  const double c = found.unknowns[0], s = found.unknowns[1];
  LeverFit fit;
  fit.scale = std::hypot(c, s);
  // Negated, so that a NaN does not pass.
  if (!(fit.scale >= kLeastScale && fit.scale <= kMostScale)) return err(LeverFault::Mismatch);
  fit.yaw_rad = std::atan2(s, c);
  Eigen::Matrix2d R;
  R << c, -s, s, c;
  R /= fit.scale;
  const Eigen::Vector2d lever = R * found.unknowns.segment<2>(2);
  fit.x_m = lever.x();
  fit.y_m = lever.y();
  const Eigen::Matrix2d covariance = R * found.covariance.block<2, 2>(2, 2) * R.transpose();
  fit.x_stddev_m = std::sqrt(covariance(0, 0));
  fit.y_stddev_m = std::sqrt(covariance(1, 1));
  const Eigen::Vector2d across = Eigen::Vector2d{-s, c} / (fit.scale * fit.scale);
  fit.yaw_stddev_rad = std::sqrt(across.dot(found.covariance.topLeftCorner<2, 2>() * across));
  fit.rms_mps2 = std::sqrt(found.variance);
  fit.windows = windows.size();
  return fit;
}

}  // namespace nacelle::calibration
