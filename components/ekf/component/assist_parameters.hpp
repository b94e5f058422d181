// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ekf/component/ekf_options.hpp"

namespace nacelle::ekf {

/// Declares the switches of one input.
void declare_assist_switches(Node& node, InputKind kind, const std::string& input);
/// Declares the numbers that all of them share.
void declare_assist_numbers(Node& node);
/// Reads one input's switches.
void read_assist_switches(const Node& node, InputOptions& input);
/// Reads the numbers; decides which IMU and which wheels are compared. After inputs and filter.
/// Errors: a number out of its range, a switch on more than one input of a kind, or on one that does not fuse what it needs.
[[nodiscard]] Result<void, Problem> read_assists(const Node& node, EkfOptions& options);

}  // namespace nacelle::ekf
