// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nacelle::transport_iceoryx {

/// iceoryx cuts each part of a name after this many characters, silently: two long topics would become one.
inline constexpr std::size_t kMostNameBytes = 100;

/// The name itself where it is short enough; else its end, which tells topics apart for a person, behind a hash of the whole,
/// which tells them apart for iceoryx.
[[nodiscard]] std::string short_name(std::string_view name);

}  // namespace nacelle::transport_iceoryx
