// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/network_names.hpp"

#include <algorithm>
#include <cctype>
#include <string>

namespace nacelle {
namespace {

bool is_made_of(std::string_view text, std::string_view others) {
  return std::all_of(text.begin(), text.end(), [&](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || others.find(c) != std::string_view::npos;
  });
}

std::string shown_in_quotes(std::string_view value) {
  std::string text(value.substr(0, 80));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + text + "'";
}

}  // namespace

Result<void, Problem> validate_peer(std::string_view peer) {
  if (peer.empty()) return err(Problem{"", "the peer is empty", "a host name or an address"});
  if (peer.size() > kMostPeerBytes) {
    return err(
        Problem{"", "the peer " + shown_in_quotes(peer) + " has more than " + std::to_string(kMostPeerBytes) + " bytes",
                "a host name or an address"});
  }
  if (is_made_of(peer, ".-_:[]%")) return {};
  return err(Problem{"", "the peer " + shown_in_quotes(peer) + " is not an address", "a host name or an address"});
}

Result<void, Problem> validate_interface(std::string_view name) {
  if (!name.empty() && name.size() <= kMostInterfaceBytes && is_made_of(name, ".-_:%@")) return {};
  return err(Problem{"", shown_in_quotes(name.substr(0, kMostInterfaceBytes)) + " is not an interface",
                     "a name from `ip link`, or an address"});
}

Result<void, Problem> validate_domain(long long domain) {
  if (domain >= 0 && domain <= kMostDomain) return {};
  return err(Problem{"", std::to_string(domain) + " is not a domain", "0 to 101 work everywhere"});
}

}  // namespace nacelle
