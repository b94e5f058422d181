// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "joy/port/pad_port.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/io/descriptor.hpp"

namespace nacelle::joy {

/// Which gamepad is meant: `path`, if it is given, otherwise the first one called `name`, otherwise the `index`-th that is there.
struct PadWish {
  std::string path{};  ///< "/dev/input/by-id/usb-...-event-joystick"
  std::string name{};
  std::size_t index = 0;  ///< Counted from 0, in the order of the kernel's numbers.
  std::filesystem::path folder = "/dev/input";
};

struct FoundPad {
  io::Descriptor device;  ///< Open for reading, without waiting; its events have times of CLOCK_MONOTONIC.
  PadInfo info;
};
struct NoPad {
  io::StreamFault fault;  ///< NotFound: it may come. NotUsable: it is there, or something else is.
  Problem problem;
};

/// Looks for the gamepad and opens it. Allocates.
[[nodiscard]] Result<FoundPad, NoPad> find_pad(const PadWish& wish);

/// Reads what an open input device has and how it stands; nothing if it is none, or is gone.
[[nodiscard]] std::optional<PadInfo> inspect_device(int device, const std::string& path);

}  // namespace nacelle::joy
