// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nacelle::networking {

/// A network interface of this machine, as reported by the kernel.
struct NetworkLink {
  int index = 0;  ///< Changes when a link is removed and added again.
  std::string name;
  bool on = false;  ///< Enabled (IFF_UP).
  bool up = false;  ///< Enabled, and with a carrier.
  bool is_loopback = false;
  bool has_multicast = false;
  std::vector<std::string> addresses;  ///< IPv4 and IPv6, sorted.
  friend bool operator==(const NetworkLink&, const NetworkLink&) = default;
};
/// Returns the interfaces, sorted by index; nothing if the kernel's query fails.
[[nodiscard]] std::vector<NetworkLink> network_links();

/// Returns the addresses besides lo at which programs of this machine discover each other: the IPv4 addresses of
/// enabled links, those with multicast first.
[[nodiscard]] std::vector<std::string> addresses_on_the_lan();

/// Reports that a link or an address of this machine was added or removed.
/// Threads: one.
class LinkWatch {
 public:
  LinkWatch();
  ~LinkWatch();
  LinkWatch(const LinkWatch&) = delete;
  LinkWatch& operator=(const LinkWatch&) = delete;

  /// Returns a descriptor that is readable after a change; -1 if the kernel does not support it.
  [[nodiscard]] int descriptor() const { return fd_; }
  /// Resets the descriptor.
  void drain() const;

 private:
  int fd_ = -1;
};

}  // namespace nacelle::networking
