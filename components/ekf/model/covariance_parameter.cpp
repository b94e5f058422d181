// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/covariance_parameter.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>

namespace nacelle::ekf {

Result<CovarianceParameter, std::string> read_covariance(const std::vector<double>& numbers,
                                                         const StateMatrix& otherwise) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i])) return err(fmt::format("number {} is not finite", i));
  }
  CovarianceParameter read{StateMatrix::Zero(), {}};
  switch (numbers.size()) {
    case 15: read.matrix.diagonal() = Eigen::Map<const StateVector>(numbers.data()); break;
    case 225: read.matrix = Eigen::Map<const Eigen::Matrix<double, 15, 15, Eigen::RowMajor>>(numbers.data()); break;
    case 36:
      read.matrix = otherwise;
      read.matrix.topLeftCorner<6, 6>() =
          Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(numbers.data());
      read.note =
          "36 numbers are taken as the 6x6 block of x, y, z, roll, pitch, yaw; velocities and accelerations keep "
          "their defaults (15 numbers give the diagonal, 225 everything)";
      break;
    default:
      return err(fmt::format("has {} numbers; give 15 (the diagonal), 225 (all, row by row) or 36 (the 6x6 pose block)",
                             numbers.size()));
  }
  for (int i = 0; i < kStates; ++i) {
    if (read.matrix(i, i) < 0.0) {
      return err(fmt::format("the variance of {} is negative ({})", kStateNames[static_cast<std::size_t>(i)],
                             read.matrix(i, i)));
    }
  }
  const StateMatrix transposed = read.matrix.transpose();
  if ((read.matrix - transposed).cwiseAbs().maxCoeff() > 1e-9 * read.matrix.cwiseAbs().maxCoeff()) {
    return err(std::string{"the matrix is not symmetric"});
  }
  read.matrix = 0.5 * (read.matrix + transposed);
  const Eigen::LDLT<StateMatrix> factors{read.matrix};
  const double tolerance = -1e-12 * read.matrix.diagonal().maxCoeff();
  if (factors.info() != Eigen::Success || factors.vectorD().minCoeff() < tolerance) {
    return err(
        std::string{"the matrix is not positive semidefinite: some combination of states has a negative variance"});
  }
  return read;
}

StateMatrix default_process_noise() {
  StateVector diagonal;
  diagonal << 0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015;
  return diagonal.asDiagonal();
}

StateMatrix default_initial_covariance() { return StateMatrix::Identity() * 1e-9; }

}  // namespace nacelle::ekf
