// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>

#include "nacelle/msgs/any_message.hpp"
#include "transport_dds/wire/network_settings.hpp"

namespace nacelle::networking {

/// Returns the services of a container's node that are refused to callers on the network, by full name, each with the
/// response that refuses the call. `node`: the container's.
///
/// Without `allow_load`: the services that load and unload code. Without `remote_control` and without DDS Security,
/// whose permissions decide: those that release emergency stops, change the network or shut the robot down. Pure.
[[nodiscard]] std::map<std::string, std::shared_ptr<const msgs::AnyMessage>> refused_services(
    const std::string& node, const transport_dds::NetworkSettings& settings);

}  // namespace nacelle::networking
