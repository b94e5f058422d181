// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ekf/component/ekf_options.hpp"

namespace nacelle::ekf {

/// An input that the parameters name: "odom0", ...
struct NamedInput {
  InputKind kind{};
  std::string name;
};

/// The inputs that the overrides name, odom0, odom1, ... up to the first gap, then pose, twist and imu; the planar preset
/// (odom0, imu0) if they name none.
[[nodiscard]] std::vector<NamedInput> named_inputs(const Node& node);

/// What is behind the last gap in a numbering ("odom2" without "odom1"): misspelt, most likely.
[[nodiscard]] std::vector<std::string> inputs_behind_a_gap(const Node& node);

/// Inputs that are given without saying what to fuse of them ("imu0" without "imu0_config").
[[nodiscard]] std::vector<std::string> inputs_without_config(const Node& node);
/// Parameters of inputs that are not given ("imu0_config" without "imu0"), each with its input's name.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> parameters_of_absent_inputs(const Node& node);

}  // namespace nacelle::ekf
