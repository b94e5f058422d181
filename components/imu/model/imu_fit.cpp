// SPDX-License-Identifier: Apache-2.0
#include "imu/model/imu_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace nacelle::imu {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Eigen::Vector3d eigen(const Vector3& v) { return {v[0], v[1], v[2]}; }
Eigen::Matrix3d eigen(const Matrix3& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{m.data()};
}
Vector3 plain(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Matrix3 plain(const Eigen::Matrix3d& m) {
  Matrix3 rows{};
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{rows.data()} = m;
  return rows;
}

Eigen::Matrix3d rotation(const Vector3& rpy) {
  return (Eigen::AngleAxisd{rpy[2], Eigen::Vector3d::UnitZ()} * Eigen::AngleAxisd{rpy[1], Eigen::Vector3d::UnitY()} *
          Eigen::AngleAxisd{rpy[0], Eigen::Vector3d::UnitX()})
      .toRotationMatrix();
}

/// The size of the readings: the equations are solved in its unit, so that teslas do not vanish beside ones.
double size_of(const std::vector<Vector3>& readings) {
  double sum = 0.0;
  for (const auto& v : readings) sum += eigen(v).norm();
  return sum / static_cast<double>(readings.size());
}

void set_errors(VectorFit& fit, const std::vector<Vector3>& readings) {
  double squares = 0.0;
  for (const auto& v : readings) {
    Eigen::Vector3d c = eigen(fit.matrix) * (eigen(v) - eigen(fit.bias));
    if (fit.is_flat) c.z() = 0.0;
    squares += std::pow(c.norm() - fit.length, 2);
  }
  fit.rms_error = std::sqrt(squares / static_cast<double>(readings.size()));
}

/// The quadric of dimension n, v'Av + 2b'v = 1, with the upper triangle of A first.
Result<VectorFit, FitFault> fit_quadric(const std::vector<Vector3>& readings, int n) {
  const int unknowns = n * (n + 1) / 2 + n;
  if (readings.size() < static_cast<std::size_t>(2 * unknowns)) return err(FitFault::TooFew);
  const double unit = size_of(readings);
  // About the mean: a bias far larger than the field would spoil the equations.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& v : readings) middle += eigen(v) / static_cast<double>(readings.size());
  if (n == 2) middle.z() = 0.0;
  MatrixXd rows(static_cast<int>(readings.size()), unknowns);
  for (int i = 0; i < rows.rows(); ++i) {
    const Eigen::Vector3d v = (eigen(readings[static_cast<std::size_t>(i)]) - middle) / unit;
    int column = 0;
    for (int r = 0; r < n; ++r) {
      for (int c = r; c < n; ++c) rows(i, column++) = (r == c ? 1.0 : 2.0) * v[r] * v[c];
    }
    for (int r = 0; r < n; ++r) rows(i, column++) = 2.0 * v[r];
  }
  const VectorXd x = rows.colPivHouseholderQr().solve(VectorXd::Ones(rows.rows()));
  MatrixXd A(n, n);
  int column = 0;
  for (int r = 0; r < n; ++r) {
    for (int c = r; c < n; ++c) A(r, c) = A(c, r) = x[column++];
  }
  const VectorXd b = x.tail(n);
  const VectorXd centre = -A.colPivHouseholderQr().solve(b);
  const double k = 1.0 + centre.dot(A * centre);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver{A / k};
  const VectorXd values = solver.eigenvalues();
  if (!values.allFinite() || values.minCoeff() <= 0.0) return err(FitFault::NoEllipsoid);
  // The longest half axis beside the shortest: soft iron bends a field, and does not make a needle of it.
  if (values.maxCoeff() / values.minCoeff() > 9.0) return err(FitFault::Absurd);
  double product = 1.0;
  for (int i = 0; i < n; ++i) product *= values[i];
  const double radius = std::pow(product, -0.5 / n);
  const MatrixXd root = solver.eigenvectors() * values.cwiseSqrt().asDiagonal() * solver.eigenvectors().transpose();
  VectorFit fit;
  fit.is_flat = n == 2;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix.topLeftCorner(n, n) = radius * root;
  Eigen::Vector3d bias = middle;
  bias.head(n) += unit * centre;
  fit.bias = plain(bias);
  fit.matrix = plain(matrix);
  fit.length = unit * radius;
  set_errors(fit, readings);
  return fit.rms_error > 0.2 * fit.length ? Result<VectorFit, FitFault>{err(FitFault::NoEllipsoid)} : fit;
}

/// Whether the corrected readings point into every octant (of the plane: every eighth of the circle).
bool is_covered(const std::vector<Vector3>& readings, const VectorFit& fit) {
  std::array<bool, 8> seen{};
  for (const auto& v : readings) {
    const Eigen::Vector3d c = eigen(fit.matrix) * (eigen(v) - eigen(fit.bias));
    const auto sector = static_cast<std::size_t>((std::atan2(c.y(), c.x()) / std::numbers::pi + 1.0) * 4.0) % 8;
    seen[fit.is_flat ? sector : (c.x() > 0 ? 1U : 0U) | (c.y() > 0 ? 2U : 0U) | (c.z() > 0 ? 4U : 0U)] = true;
  }
  return std::ranges::all_of(seen, [](bool one) { return one; });
}

}  // namespace

Result<VectorFit, FitFault> fit_acceleration(const std::vector<Vector3>& at_rest, double gravity_mps2) {
  if (at_rest.size() < 6) return err(FitFault::TooFew);
  std::array<bool, 6> seen{};
  MatrixXd rows(static_cast<int>(at_rest.size()), 6);
  for (int i = 0; i < rows.rows(); ++i) {
    const Eigen::Vector3d v = eigen(at_rest[static_cast<std::size_t>(i)]) / gravity_mps2;
    int axis = 0;
    v.cwiseAbs().maxCoeff(&axis);
    seen[static_cast<std::size_t>(2 * axis + (v[axis] > 0 ? 0 : 1))] = true;
    rows.row(i) << v.x() * v.x(), v.y() * v.y(), v.z() * v.z(), v.x(), v.y(), v.z();
  }
  if (!std::ranges::all_of(seen, [](bool one) { return one; })) return err(FitFault::NotCovered);
  const VectorXd x = rows.colPivHouseholderQr().solve(VectorXd::Ones(rows.rows()));
  double k = 1.0;
  Eigen::Vector3d bias, scale;
  for (int i = 0; i < 3; ++i) {
    bias[i] = -0.5 * x[i + 3] / x[i];
    k += x[i] * bias[i] * bias[i];
  }
  for (int i = 0; i < 3; ++i) scale[i] = std::sqrt(x[i] / k);
  if (!scale.allFinite() || !bias.allFinite()) return err(FitFault::NoEllipsoid);
  if ((scale - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff() > 1.0 / 3.0) return err(FitFault::Absurd);
  VectorFit fit;
  fit.bias = plain(Eigen::Vector3d{bias * gravity_mps2});
  fit.matrix = {scale.x(), 0, 0, 0, scale.y(), 0, 0, 0, scale.z()};
  fit.length = gravity_mps2;
  set_errors(fit, at_rest);
  return fit;
}

Result<VectorFit, FitFault> fit_field(const std::vector<Vector3>& readings) {
  if (readings.size() < 20) return err(FitFault::TooFew);
  Vector3 least = readings.front(), most = readings.front();
  for (const auto& v : readings) {
    for (std::size_t i = 0; i < 3; ++i) {
      least[i] = std::min(least[i], v[i]);
      most[i] = std::max(most[i], v[i]);
    }
  }
  const double across = std::max(most[0] - least[0], most[1] - least[1]);
  const bool is_flat = most[2] - least[2] < 0.3 * across;
  auto fit = fit_quadric(readings, is_flat ? 2 : 3);
  if (fit && !is_covered(readings, *fit)) return err(FitFault::NotCovered);
  return fit;
}

Vector3 in_sensor_axes(const Vector3& in_frame, const Vector3& mounting_rpy_rad) {
  return plain(Eigen::Vector3d{rotation(mounting_rpy_rad).transpose() * eigen(in_frame)});
}

AffineCorrection composed(const AffineCorrection& now, const Vector3& mounting_rpy_rad, const VectorFit& fit) {
  // c' = M2 (R M (v - b) - b2) = R M' (v - b')  with  M' = R' M2 R M  and  b' = b + inv(M) R' b2
  const Eigen::Matrix3d R = rotation(mounting_rpy_rad), M = eigen(now.matrix);
  const Eigen::Vector3d bias = eigen(now.bias) + M.inverse() * R.transpose() * eigen(fit.bias);
  return {plain(bias), plain(Eigen::Matrix3d{R.transpose() * eigen(fit.matrix) * R * M})};
}

}  // namespace nacelle::imu
