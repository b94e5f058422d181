// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nacelle::transport_iceoryx {

/// iceoryx silently truncates each part of a service's name to this many characters, so that two long topics could get
/// the same name.
inline constexpr std::size_t kMostNameBytes = 100;

/// Returns the name itself if it is short enough; otherwise a hash of the whole name, which makes it unique, and the
/// name's end, which keeps it readable.
[[nodiscard]] std::string short_name(std::string_view name);

}  // namespace nacelle::transport_iceoryx
