// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/msgs/message_type.hpp"

#include <span>
#include <type_description_interfaces/srv/get_type_description.hpp>
#include <variant>
#include <vector>

namespace nacelle::msgs {

// The answers of ~/get_type_description about a node's types, so that a tool can read messages of which it has no
// package.
// Source: rosidl_generator_type_description and rosidl_generator_c (full__description.c.em), rcl's node.c (jazzy).

using TypeDescription = ::type_description_interfaces::msg::TypeDescription;
using TypeSource = ::type_description_interfaces::msg::TypeSource;
using GetTypeDescription = ::type_description_interfaces::srv::GetTypeDescription;

/// A type that is in use by a node. Never null.
using UsedType = std::variant<const MessageType*, const ServiceType*, const ActionType*>;

/// The fields of a type, and of all types that it is made of, sorted by name. Without the default values it is what the
/// type's hash is the hash of.
[[nodiscard]] TypeDescription describe(const UsedType& used);

/// The definitions of a type and of those it is made of, in the same order. Our definitions have ROS 2's fields, not
/// its comments. Types that no file defines (a service's request) are "implicit" and have no text.
[[nodiscard]] std::vector<TypeSource> sources_of(const UsedType& used);

/// The answer of a node that uses these types. As with rcl the hash decides, and the name in the request is not looked
/// at.
[[nodiscard]] GetTypeDescription::Response answer(const GetTypeDescription::Request& request,
                                                  std::span<const UsedType> in_use);

}  // namespace nacelle::msgs
