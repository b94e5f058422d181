// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle {

/// When the network sees a reader. A node that reads several types on one name (a base: Twist and TwistStamped) would give the
/// name several types there, and ROS 2's tools refuse such a topic.
enum class Announced : std::uint8_t {
  Always,
  ByDefault,        ///< One of several types: while a publisher of this type is there, or none of any of them.
  WithItsPublisher  ///< One of several types: only while a publisher of this type is there.
};

}  // namespace nacelle
