// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nacelle::networking {

/// A network interface of this machine, as the kernel has it now.
struct NetworkLink {
  int index = 0;  ///< A link that was removed and added again has another one.
  std::string name;
  bool on = false;  ///< Switched on.
  bool up = false;  ///< Switched on, and with a carrier.
  bool is_loopback = false;
  bool has_multicast = false;
  std::vector<std::string> addresses;  ///< IPv4 and IPv6, sorted.
  friend bool operator==(const NetworkLink&, const NetworkLink&) = default;
};
/// Returns the interfaces by index. Empty if the kernel cannot be queried.
[[nodiscard]] std::vector<NetworkLink> network_links();

/// Where programs of this machine may look for each other besides lo: IPv4 addresses of links that are switched on, by
/// link; those of links for multicast first.
[[nodiscard]] std::vector<std::string> addresses_on_the_lan();

/// Reports that a link or an address of this machine was added or removed.
/// Threads: one.
class LinkWatch {
 public:
  LinkWatch();
  ~LinkWatch();
  LinkWatch(const LinkWatch&) = delete;
  LinkWatch& operator=(const LinkWatch&) = delete;

  /// Readable when something has changed; -1 if the kernel does not support it.
  [[nodiscard]] int descriptor() const { return fd_; }
  /// Resets the descriptor.
  void drain() const;

 private:
  int fd_ = -1;
};

}  // namespace nacelle::networking
