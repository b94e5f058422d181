// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include "ekf/component/input.hpp"
#include "ekf/model/innovations.hpp"

namespace nacelle::ekf {

/// Returns "imu0 angular_velocity.z" for the part "imu0 angular_velocity" and its state vyaw.
[[nodiscard]] std::string axis_name(std::string_view part, StateIndex state);

/// What the innovations of an axis say about its covariance, as the end of a sentence; empty if there is nothing to say.
/// Of several findings the one that a builder can mend first: noise, then a bias, then a filter that is too sure or too unsure.
[[nodiscard]] std::string finding_of(const AxisNoise& noise);

/// Adds an input part's rate, delay, and per axis NIS, noise, offset and scale to its diagnostics, and the worst finding as
/// `sentence`: "imu0 angular_velocity.z is 3.1 times as noisy as its covariance says". Allocates: yes.
void add_innovations(const Input::Part& part, const Filter& filter, diagnostic_msgs::msg::DiagnosticStatus& status);

}  // namespace nacelle::ekf
