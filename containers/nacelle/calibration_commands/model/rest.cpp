// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/rest.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::calibration {

Vector3 mean_of(const std::vector<Vector3>& readings) {
  Vector3 mean{};
  for (const auto& v : readings) {
    for (std::size_t i = 0; i < 3; ++i) mean[i] += v[i] / static_cast<double>(readings.size());
  }
  return mean;
}

double scatter_of(const std::vector<Vector3>& readings) {
  const Vector3 mean = mean_of(readings);
  Vector3 squares{};
  for (const auto& v : readings) {
    for (std::size_t i = 0; i < 3; ++i)
      squares[i] += std::pow(v[i] - mean[i], 2) / static_cast<double>(readings.size());
  }
  return std::sqrt(*std::max_element(squares.begin(), squares.end()));
}

Result<void, RestFault> check_rest(const RestReadings& readings) {
  if (readings.rates_rps.size() < kLeastReadings) return err(RestFault::TooFew);
  const double rates = scatter_of(readings.rates_rps), accelerations = scatter_of(readings.accelerations_mps2);
  // Negated, so that a NaN does not pass.
  if (!(rates <= kMostRateScatter && accelerations <= kMostAccelerationScatter)) return err(RestFault::Moving);
  for (const double rate : mean_of(readings.rates_rps)) {
    if (!(std::abs(rate) <= kMostRate)) return err(RestFault::Turning);
  }
  return {};
}

Side side_up(const Vector3& acceleration_mps2) {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(acceleration_mps2[i]) > std::abs(acceleration_mps2[axis])) axis = i;
  }
  const bool is_positive = acceleration_mps2[axis] > 0;
  return {2 * axis + (is_positive ? 0U : 1U), std::string{is_positive ? '+' : '-'} + "xyz"[axis]};
}

}  // namespace nacelle::calibration
