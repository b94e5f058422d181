// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/node/generic_topics.hpp"

// Topics that a recorder reads whether they are chosen or not.
namespace nacelle::record {

[[nodiscard]] bool is_emergency_stop(const EndpointSpec& spec);
/// A robot's description (URDF).
[[nodiscard]] bool is_description(const EndpointSpec& spec);
/// Returns the text of a std_msgs/String.
[[nodiscard]] std::string text_in(const msgs::MessageType& type, const void* message);
/// Returns the value of a std_msgs/Bool.
[[nodiscard]] bool is_set(const msgs::MessageType& type, const void* message);

}  // namespace nacelle::record
