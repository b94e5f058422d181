// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/innovation_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nacelle::ekf {
namespace {

// Ratios of standard deviations between these are no finding: two hundred measurements tell them from 1, a builder does not.
constexpr double kNoisy = 1.5, kPrecise = 0.4;
// Below this a quantity stands still, as wheels at rest do, which says nothing of its sensor.
constexpr double kStands = 0.01;
// Mean of innovation^2 / S.
constexpr double kTooSure = 3.0, kTooUnsure = 0.2;
// Of the root of NIS: so much of it is one and the same offset.
constexpr double kMostlyOffset = 0.5;

std::string axis_word(std::string_view part, StateIndex state) {
  const bool vector = part.ends_with("angular_velocity") || part.ends_with("linear_acceleration");
  if (vector) return std::string(1, "xyz"[state % 3]);
  return std::string{kStateNames[state]};
}

// How far a figure is from what it should be, to find the worst axis.
double oddness(const AxisNoise& noise) {
  if (noise.noise > kNoisy) return 1e3 + noise.noise;
  return noise.nis > 1.0 ? noise.nis : 1.0 / std::max(noise.nis, 1e-6) / 10.0;
}

}  // namespace

std::string axis_name(std::string_view part, StateIndex state) {
  return fmt::format("{}.{}", part, axis_word(part, state));
}

std::string finding_of(const AxisNoise& noise) {
  if (noise.count < Innovations::kEnough) return {};
  if (noise.noise > kNoisy) {
    std::string text = fmt::format("is {:.1f} times as noisy as its covariance says", noise.noise);
    if (noise.scale > 1.0) text += fmt::format("; the filter takes it as {:.1f} times", noise.scale);
    return text;
  }
  if (noise.nis > kTooSure) {
    const double sigmas = std::sqrt(noise.nis);
    if (std::abs(noise.offset) > kMostlyOffset * sigmas)
      return fmt::format("is off by {:+.1f} standard deviations on average: a bias, slip or a delay", noise.offset);
    return fmt::format(
        "differs from the prediction by {:.1f} standard deviations, for longer than noise does: slip, a delay, or too "
        "little process noise",
        sigmas);
  }
  if (noise.nis < kTooUnsure && noise.noise > kStands) {
    if (noise.noise < kPrecise)
      return fmt::format("is {:.1f} times as precise as its covariance says", 1.0 / noise.noise);
    return fmt::format("agrees with the prediction {:.1f} times better than the filter expects: too much process noise",
                       1.0 / std::sqrt(std::max(noise.nis, 1e-6)));
  }
  return {};
}

void add_innovations(const Input::Part& part, const Filter& filter, diagnostic_msgs::msg::DiagnosticStatus& status) {
  const auto add = [&status](std::string key, std::string value) {
    auto& pair = status.values.emplace_back();
    pair.key = std::move(key);
    pair.value = std::move(value);
  };
  const double usual_s = to_seconds(filter.usual_interval(part.number));
  add("rate", fmt::format("{:.2f}", usual_s > 0.0 ? 1.0 / usual_s : 0.0));
  add("delay", fmt::format("{:.6f}", to_seconds(filter.stats(part.number).behind)));
  std::string worst;
  double worst_oddness = 0.0;
  for (int i = 0; i < kStates; ++i) {
    const auto state = static_cast<StateIndex>(i);
    const AxisNoise noise = filter.innovations().axis(part.number, state);
    if (noise.count < Innovations::kEnough) continue;
    const std::string axis = axis_word(part.name, state);
    add("nis " + axis, fmt::format("{:.3f}", noise.nis));
    add("noise " + axis, fmt::format("{:.3f}", noise.noise));
    add("offset " + axis, fmt::format("{:.3f}", noise.offset));
    add("scale " + axis, fmt::format("{:.3f}", noise.scale));
    const std::string finding = finding_of(noise);
    if (finding.empty() || oddness(noise) <= worst_oddness) continue;
    worst_oddness = oddness(noise);
    worst = axis_name(part.name, state) + " " + finding;
  }
  if (!worst.empty()) add("sentence", worst);
}

}  // namespace nacelle::ekf
