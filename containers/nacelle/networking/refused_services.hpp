// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>

#include "nacelle/msgs/any_message.hpp"
#include "transport_dds/wire/network_settings.hpp"

namespace nacelle::networking {

/// Returns the services of a container's node that callers on the network may not use, by full name, each with the response that they
/// get: those that load code without `allow_load`; those that release emergency stops, change the network or end the robot without
/// `remote_control` and without DDS Security, whose permissions decide. `node`: the container's. Pure.
[[nodiscard]] std::map<std::string, std::shared_ptr<const msgs::AnyMessage>> refused_services(
    const std::string& node, const transport_dds::NetworkSettings& settings);

}  // namespace nacelle::networking
