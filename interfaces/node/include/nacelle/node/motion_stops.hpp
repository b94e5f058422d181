// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace nacelle {

/// How often the host has stopped what moves from outside of the components, by their stop frames (Node::register_safe_stop()).
///
/// A stop frame holds until the next command. A component with a control loop of its own remembers the count when it is
/// activated, and commands nothing more, but the stop, once there is another one; until it is activated anew.
/// The host counts first, and writes the frames then.
/// Threads: any.
struct MotionStops {
  std::atomic<std::uint64_t> count{0};
};

/// For Node::shared_object(): the count of a container.
inline constexpr const char* kMotionStopsName = "nacelle.motion_stops";
[[nodiscard]] std::shared_ptr<void> make_motion_stops();

}  // namespace nacelle
