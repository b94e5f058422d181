// SPDX-License-Identifier: Apache-2.0
#include "odometry/component/slip_parameters.hpp"

#include <algorithm>
#include <array>

namespace nacelle::odometry {

void declare_slip_parameters(Node& node, const SlipModel& defaults) {
  const auto say = [](const char* text) { return ParameterDescriptor{.description = text, .read_only = true}; };
  node.declare_parameter(
      "slip.distance_stddev_per_sqrt_m", defaults.distance_m,
      say("Error of the distance driven, m per root of a metre; its variance grows with the distance."));
  node.declare_parameter("slip.lateral_stddev_per_sqrt_m", defaults.lateral_m,
                         say("Slide to the side, m per root of a metre driven."));
  node.declare_parameter("slip.heading_stddev_per_sqrt_m", defaults.heading_rad,
                         say("Error of the heading, rad per root of a metre driven."));
  node.declare_parameter("slip.heading_stddev_per_sqrt_rad", defaults.turn_rad,
                         say("Error of the heading, rad per root of a radian turned."));
  const StepNoise d;
  node.declare_parameter(
      "k_left", d.k_left_m,
      say("Variance of the left distance per metre, m^2/m. If one of k_left, k_right and k_turn is given, "
          "they count in place of slip.*."));
  node.declare_parameter("k_right", d.k_right_m, say("Variance of the right distance per metre, m^2/m; see k_left."));
  node.declare_parameter("k_turn", d.k_turn_rad,
                         say("Variance of the heading per radian turned, rad^2/rad; see k_left."));
}

SlipModel read_slip_model(const Node& node) {
  return {node.get<double>("slip.distance_stddev_per_sqrt_m"), node.get<double>("slip.lateral_stddev_per_sqrt_m"),
          node.get<double>("slip.heading_stddev_per_sqrt_m"), node.get<double>("slip.heading_stddev_per_sqrt_rad")};
}

std::optional<StepNoise> read_step_noise(const Node& node) {
  constexpr std::array kNames{"k_left", "k_right", "k_turn"};
  const auto& given = node.parameters().overrides();
  if (std::ranges::none_of(kNames, [&given](const char* name) { return given.count(name) != 0; })) return std::nullopt;
  return StepNoise{node.get<double>("k_left"), node.get<double>("k_right"), node.get<double>("k_turn")};
}

}  // namespace nacelle::odometry
