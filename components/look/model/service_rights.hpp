// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "look/model/access.hpp"

namespace nacelle::look {

/// What a viewer must have to call a service of this type ("std_srvs/srv/SetBool", or its request's type). View: services that only answer.
/// None: not even Operate will do, since a page may be open to the network: what widens the network or ends the robot.
[[nodiscard]] Right right_for_service(std::string_view type);

}  // namespace nacelle::look
