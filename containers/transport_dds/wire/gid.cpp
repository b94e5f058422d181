// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/gid.hpp"

#include <cstring>
#include <string_view>

namespace nacelle::transport_dds {

Gid Gid::participant() const {
  constexpr std::array<std::uint8_t, kBytes - kPrefixBytes> kEntity{0x00, 0x00, 0x01, 0xC1};
  Gid gid = *this;
  std::copy(kEntity.begin(), kEntity.end(), gid.bytes.begin() + kPrefixBytes);
  return gid;
}

}  // namespace nacelle::transport_dds

std::size_t std::hash<nacelle::transport_dds::Gid>::operator()(const nacelle::transport_dds::Gid& gid) const noexcept {
  return std::hash<std::string_view>{}(nacelle::as_text(gid.bytes));
}
