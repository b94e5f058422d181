// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joy/model/joy_pacer.hpp"
#include "joy/port/pad_search.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::joy {

/// The parameters of the component; their names are those of ROS 2's joy, but for `dev`, which is joy_linux's.
struct JoyOptions {
  PadWish wish{};
  PadState::Settings pad{};
  JoyPacer::Settings pace{};
  DeviceOptions device{};
  Duration silence_limit = 1s;  ///< With device_lost: fault, how long the gamepad may be absent.
  /// The gamepad as people know it.
  [[nodiscard]] std::string title() const;
};

/// Declares the parameters with their defaults and ranges. Touches no hardware.
void declare_joy_parameters(Node& node);

/// Reads the declared parameters.
/// Errors: a Problem that names the parameter, its value and the way out.
[[nodiscard]] Result<JoyOptions, Problem> read_joy_parameters(const Node& node);

}  // namespace nacelle::joy
