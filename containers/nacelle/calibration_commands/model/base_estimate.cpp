// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/base_estimate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

namespace nacelle::calibration {
namespace {

constexpr int kUnknowns = 3;  // logarithms of left radius, right radius, separation
constexpr double kMostOff = 0.05;
using Unknowns = Eigen::Vector3d;

BaseGeometry changed(const BaseGeometry& base, const Unknowns& by) {
  BaseGeometry other = base;
  other.left_radius_multiplier *= std::exp(by[0]);
  other.right_radius_multiplier *= std::exp(by[1]);
  other.separation_multiplier *= std::exp(by[2]);
  return other;
}

int size_of(Measured what) { return what == Measured::Distance ? 1 : what == Measured::Position ? 2 : 3; }

/// The measured numbers of a way, minus what the wheels say, with the covariances of the wheels' part.
struct Residual {
  Eigen::VectorXd value;
  std::array<Eigen::MatrixXd, 3> by_slip;
  Eigen::MatrixXd by_measurement;
  bool is_turn = false;
  double off_m = 0.0, length_m = 0.0;
};

Eigen::VectorXd predicted(const DrivenWay& way, const Eigen::Vector3d& pose) {
  if (way.what == Measured::Distance) return Eigen::VectorXd::Constant(1, std::hypot(pose.x(), pose.y()));
  return pose.head(size_of(way.what));
}

Residual residual_of(const BaseGeometry& base, const DrivenWay& way, const MeasurementNoise& noise) {
  const PathEnd end = end_of(base, way.path);
  const int size = size_of(way.what);
  Eigen::MatrixXd pick = Eigen::MatrixXd::Identity(3, 3).topRows(size);
  if (way.what == Measured::Distance) {
    const double chord_m = std::hypot(end.pose.x(), end.pose.y());
    pick.row(0) << end.pose.x() / chord_m, end.pose.y() / chord_m, 0.0;
  }
  Residual r;
  r.value = Eigen::Vector3d{way.x_m, way.y_m, way.yaw_rad}.head(size) - predicted(way, end.pose);
  if (way.what == Measured::Pose) r.value[2] = std::remainder(r.value[2], 2.0 * std::numbers::pi);
  for (std::size_t part = 0; part < r.by_slip.size(); ++part)
    r.by_slip[part] = pick * end.by_slip[part] * pick.transpose();
  Eigen::VectorXd variances = Eigen::VectorXd::Constant(size, noise.position_m * noise.position_m);
  if (way.what == Measured::Pose) variances[2] = noise.yaw_rad * noise.yaw_rad;
  r.by_measurement = variances.asDiagonal();
  r.off_m = r.value.head(std::min(size, 2)).norm();
  for (std::size_t i = 1; i < way.path.size(); ++i)
    r.length_m += std::abs(distance_m(base, way.path[i] - way.path[i - 1]));
  r.is_turn = std::abs(end.pose.z()) * base.separation_m() / 2.0 > r.length_m;
  return r;
}

Eigen::MatrixXd covariance_of(const Residual& r, const SlipNoise& slip) {
  return slip.distance_m * r.by_slip[0] + slip.heading_per_m * r.by_slip[1] + slip.heading_per_rad * r.by_slip[2] +
         r.by_measurement;
}

double chi_squared(const Residual& r, const SlipNoise& slip) {
  return r.value.dot(covariance_of(r, slip).llt().solve(r.value));
}

/// The slopes of what the wheels say, by the unknowns.
Eigen::MatrixXd slopes_of(const BaseGeometry& base, const DrivenWay& way) {
  constexpr double kStep = 1e-5;
  Eigen::MatrixXd slopes(size_of(way.what), kUnknowns);
  for (int i = 0; i < kUnknowns; ++i) {
    const Unknowns by = kStep * Unknowns::Unit(i);
    slopes.col(i) = (predicted(way, end_of(changed(base, by), way.path).pose) -
                     predicted(way, end_of(changed(base, -by), way.path).pose)) /
                    (2.0 * kStep);
  }
  return slopes;
}

struct Fit {
  BaseGeometry base;
  std::vector<Residual> residuals;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

std::vector<Residual> residuals_of(const BaseGeometry& base, const std::vector<DrivenWay>& ways,
                                   const MeasurementNoise& noise) {
  std::vector<Residual> residuals;
  for (const auto& way : ways) residuals.push_back(residual_of(base, way, noise));
  return residuals;
}

double chi_squared(const std::vector<Residual>& residuals, const SlipNoise& slip) {
  double sum = 0.0;
  for (const auto& r : residuals) sum += chi_squared(r, slip);
  return sum;
}

/// Gauss-Newton with half steps where a whole one would go uphill.
Fit fit(BaseGeometry base, const std::vector<DrivenWay>& ways, const MeasurementNoise& noise, const SlipNoise& slip) {
  constexpr int kRounds = 20, kHalvings = 8;
  constexpr double kDone = 1e-9;
  Fit best{base, residuals_of(base, ways, noise)};
  for (int round = 0; round < kRounds; ++round) {
    best.information.setZero();
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const Eigen::MatrixXd slopes = slopes_of(best.base, ways[i]);
      const auto inverse = covariance_of(best.residuals[i], slip).llt();
      best.information += slopes.transpose() * inverse.solve(slopes);
      pull += slopes.transpose() * inverse.solve(best.residuals[i].value);
    }
    Unknowns step = best.information.ldlt().solve(pull);
    if (!step.allFinite()) return best;
    const double before = chi_squared(best.residuals, slip);
    bool is_better = false;
    for (int half = 0; half < kHalvings && !is_better; ++half, step *= 0.5) {
      const BaseGeometry other = changed(best.base, step);
      auto residuals = residuals_of(other, ways, noise);
      is_better = chi_squared(residuals, slip) < before;
      if (!is_better) continue;
      best.base = other;
      best.residuals = std::move(residuals);
    }
    if (!is_better || step.cwiseAbs().maxCoeff() < kDone) break;
  }
  return best;
}

/// The factor for which chi-squared equals its expectation; the least or the most if it is beyond them.
double factor_for(double expected, const std::function<double(double)>& chi_squared_of) {
  double least = std::log(1e-4), most = std::log(1e4);
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (least + most);
    (chi_squared_of(std::exp(middle)) > expected ? least : most) = middle;
  }
  return std::exp(0.5 * (least + most));
}

SlipNoise scaled(SlipNoise slip, double factor) {
  slip.distance_m *= factor;
  slip.heading_per_m *= factor;
  slip.heading_per_rad *= factor;
  return slip;
}

/// Less slip than this share of the measurement's variance, at the end of a way, cannot be told from none. None would make an odometry
/// that is sure of everything.
constexpr double kUnseenShare = 0.25;

/// Changes one part of a noise until one number of the straight ways, or of the turns, scatters as it says.
void match(double SlipNoise::*part, SlipNoise& slip, const std::vector<Residual>& residuals, bool of_turns,
           int number) {
  SlipNoise unit{0.0, 0.0, 0.0};
  unit.*part = 1.0;
  int count = 0;
  double measured = 0.0, grown = 0.0;
  for (const auto& r : residuals) {
    if (r.is_turn != of_turns) continue;
    ++count;
    measured += r.by_measurement(number, number);
    grown += (covariance_of(r, unit) - r.by_measurement)(number, number);
  }
  // One unknown is determined by each: mean and ratio of the radii, the separation.
  slip.*part *= factor_for(count - 1, [&](double factor) {
    SlipNoise with = slip;
    with.*part *= factor;
    double chi = 0.0;
    for (const auto& r : residuals) {
      if (r.is_turn == of_turns) chi += r.value[number] * r.value[number] / covariance_of(r, with)(number, number);
    }
    return chi;
  });
  slip.*part = std::max(slip.*part, kUnseenShare * measured / grown);
}

SlipNoise noise_of(const std::vector<Residual>& residuals, SlipNoise slip) {
  int straight = 0, turning = 0, numbers = 0;
  bool are_poses = true;
  for (const auto& r : residuals) {
    ++(r.is_turn ? turning : straight);
    numbers += static_cast<int>(r.value.size());
    are_poses = are_poses && r.value.size() == 3;
  }
  if (are_poses && std::min(straight, turning) > kLeastExcess) {
    match(&SlipNoise::distance_m, slip, residuals, false, 0);
    match(&SlipNoise::heading_per_m, slip, residuals, false, 2);
    match(&SlipNoise::heading_per_rad, slip, residuals, true, 2);
    return slip;
  }
  const double factor =
      factor_for(numbers - kUnknowns, [&](double by) { return chi_squared(residuals, scaled(slip, by)); });
  double measured = 0.0, grown = 0.0;
  for (const auto& r : residuals) {
    measured += r.by_measurement(0, 0);
    grown += (covariance_of(r, slip) - r.by_measurement)(0, 0);
  }
  return scaled(slip, std::max(factor, kUnseenShare * measured / grown));
}

double rms_of(const std::vector<Residual>& residuals) {
  double sum = 0.0;
  for (const auto& r : residuals) sum += r.off_m * r.off_m;
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

}  // namespace

Result<BaseEstimate, EstimateFault> estimate_base(const BaseGeometry& believed, const BaseGeometry& start,
                                                  const std::vector<DrivenWay>& ways,
                                                  const MeasurementNoise& measurement) {
  constexpr int kNoiseRounds = 4;
  constexpr double kWorst = 0.05;  // relative; a base that is not known better has not been seen
  int excess = -kUnknowns;
  for (const auto& way : ways) excess += size_of(way.what);
  if (excess < 0) return err(EstimateFault::TooFew);
  SlipNoise slip;
  Fit found = fit(start, ways, measurement, slip);
  // Before the noise is found: that of contradictions hides everything.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> directions{found.information};
  if (!(directions.eigenvalues().minCoeff() >= 1.0 / (kWorst * kWorst))) return err(EstimateFault::NotSeen);
  for (int round = 0; excess >= kLeastExcess && round < kNoiseRounds; ++round) {
    slip = noise_of(found.residuals, slip);
    found = fit(found.base, ways, measurement, slip);
  }
  const double ratios[] = {found.base.left_radius_multiplier / believed.left_radius_multiplier,
                           found.base.right_radius_multiplier / believed.right_radius_multiplier,
                           found.base.separation_multiplier / believed.separation_multiplier};
  for (const double ratio : ratios) {
    // Negated, so that a NaN does not pass.
    if (!(std::abs(std::log(ratio)) <= std::log(2.0))) return err(EstimateFault::Absurd);
  }
  double off = 0.0, length = 0.0;
  for (const auto& r : found.residuals) {
    off += r.off_m;
    length += r.length_m;
  }
  if (!(off <= kMostOff * length)) return err(EstimateFault::Contradictory);
  const Eigen::Matrix3d covariance = found.information.inverse();
  const Eigen::Vector3d stddev = covariance.diagonal().cwiseSqrt();
  if (!(stddev.maxCoeff() <= kWorst)) return err(EstimateFault::NotSeen);
  BaseEstimate estimate;
  estimate.base = found.base;
  estimate.left_stddev = stddev[0];
  estimate.right_stddev = stddev[1];
  estimate.separation_stddev = stddev[2];
  if (excess >= kLeastExcess) estimate.slip = slip;
  estimate.rms_before_m = rms_of(residuals_of(believed, ways, measurement));
  estimate.rms_after_m = rms_of(found.residuals);
  return estimate;
}

}  // namespace nacelle::calibration
