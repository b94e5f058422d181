// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/innovations.hpp"

#include <algorithm>
#include <cmath>

#include "nacelle/spatial/angles.hpp"

namespace nacelle::ekf {
namespace {

// Squares of normalised innovations beyond ten standard deviations say no more than that something is wrong.
constexpr double kMostNis = 100.0;
// Standard deviation of the estimate of R over kWindow measurements, as a share of E[e^2]: 3.9 to 4.2 % for q from 0 to 30 R.
constexpr double kScatter = 0.04, kSignificant = 2.0;

bool is_angle(int state) { return state >= kRoll && state <= kYaw; }
double apart(int state, double a, double b) { return is_angle(state) ? spatial::wrap_to_pi(a - b) : a - b; }

void average(double& mean, double value, std::uint64_t count) {
  mean += (value - mean) / static_cast<double>(std::min(count, Innovations::kWindow));
}

}  // namespace

Innovations::Innovations(std::size_t parts, const InnovationOptions& options, StateMask held)
    : parts_(parts), held_(held) {
  for (std::size_t i = 0; i < std::min(parts, options.adaptive.size()); ++i) parts_[i].adaptive = options.adaptive[i];
}

const Reading& Innovations::note(std::size_t part, WallTime stamp, const Belief& prior, const Reading& reading) {
  Part& p = parts_[part];
  if (stamp > p.newest) {
    p.newest = stamp;
    for (std::size_t k = 0; k < static_cast<std::size_t>(reading.rows); ++k) {
      const int state = reading.index[k];
      if (has(held_, state)) continue;
      const double innovation = apart(state, reading.value[k], prior.mean[state]);
      const double claimed = std::max(std::abs(reading.covariance[k * (kStates + 1)]), kSmallestVariance);
      if (!std::isfinite(innovation) || !std::isfinite(claimed)) continue;
      Axis& axis = p.axes[static_cast<std::size_t>(state)];
      add(axis, innovation, prior.covariance(state, state), claimed);
      add_value(axis, state, reading.value[k]);
      if (p.adaptive && axis.count >= kEnough)
        axis.scale = std::clamp(noise_variance(axis) / axis.claimed, 1.0, kMostScale * kMostScale);
    }
  }
  return p.adaptive ? adapted(p, reading) : reading;
}

void Innovations::add(Axis& axis, double innovation, double prior_variance, double claimed) {
  ++axis.count;
  const double S = prior_variance + axis.scale * claimed;
  const double square = std::min(innovation * innovation / S, kMostNis);
  average(axis.nis, square, axis.count);
  average(axis.offset, std::copysign(std::sqrt(square), innovation), axis.count);
  average(axis.claimed, claimed, axis.count);
}

void Innovations::add_value(Axis& axis, int state, double value) {
  const double difference = apart(state, value, axis.last);
  const double second = difference - axis.last_difference;
  if (axis.run >= 3) {
    ++axis.differences;
    // An outlier moves the means by half of themselves at most; noise that is far beyond them is reached in steps.
    const double reach = kMostNis * std::max(axis.square, axis.claimed);
    const double share = std::min(1.0, reach / std::max(second * second, 1e-300));
    average(axis.square, share * second * second, axis.differences);
    average(axis.product, share * second * axis.last_second, axis.differences);
  }
  axis.run = std::min(axis.run + 1, 3);
  axis.last_second = second;
  axis.last_difference = difference;
  axis.last = value;
}

double Innovations::noise_variance(const Axis& axis) {
  const double seen = std::max(0.0, -0.5 * (axis.square + 2.0 * axis.product));
  const double counted = static_cast<double>(std::clamp<std::uint64_t>(axis.differences, 1, kWindow));
  const double scatter = kScatter * axis.square * std::sqrt(static_cast<double>(kWindow) / counted);
  return std::abs(seen - axis.claimed) > kSignificant * scatter ? seen : axis.claimed;
}

const Reading& Innovations::adapted(const Part& part, const Reading& reading) {
  bool any = false;
  std::array<double, kStates> factor{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(reading.rows); ++k) {
    const double scale = part.axes[reading.index[k]].scale;
    factor[k] = std::sqrt(scale);
    any = any || scale != 1.0;
  }
  if (!any) return reading;
  raised_ = reading;
  for (std::size_t k = 0; k < static_cast<std::size_t>(reading.rows); ++k) {
    for (std::size_t l = 0; l < static_cast<std::size_t>(reading.rows); ++l)
      raised_.covariance[k * kStates + l] *= factor[k] * factor[l];
  }
  return raised_;
}

void Innovations::restart() {
  for (Part& part : parts_) {
    part.newest = {};
    for (Axis& axis : part.axes) axis.run = 0;
  }
}

AxisNoise Innovations::axis(std::size_t part, StateIndex state) const {
  const Axis& a = parts_[part].axes[state];
  AxisNoise noise;
  noise.count = a.count;
  noise.scale = std::sqrt(a.scale);
  if (a.count < kEnough) return noise;
  noise.nis = a.nis;
  noise.offset = a.offset;
  noise.noise = std::sqrt(noise_variance(a) / a.claimed);
  return noise;
}

}  // namespace nacelle::ekf
