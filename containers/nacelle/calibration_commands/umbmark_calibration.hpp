// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ask/nodes.hpp"
#include "calibration_commands/base_calibration.hpp"
#include "calibration_commands/base_driver.hpp"
#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/wheel_reading.hpp"

namespace nacelle::cli {

/// Drives a straight line and squares both ways (model/umbmark.hpp), asks where the robot has ended or reads it from a topic, and writes
/// the multipliers of the wheels and the noise of the odometry. `node`: the base's. Returns the exit code.
int calibrate_by_squares(const BaseWish& wish, Dialogue& dialogue, ask::Nodes& nodes, const std::string& node,
                         BaseTopics topics, const BaseParameters& base);

/// Parses "X,Y", two numbers of metres; for Option::checked() and what follows. Returns the error, or an empty text.
[[nodiscard]] std::string wrong_end(const std::string& text);

}  // namespace nacelle::cli
