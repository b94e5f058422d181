// SPDX-License-Identifier: Apache-2.0
#include "networking/network_links.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <map>

namespace nacelle::networking {
namespace {

std::string text_of(const sockaddr& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const void* bytes = nullptr;
  if (address.sa_family == AF_INET) bytes = &reinterpret_cast<const sockaddr_in&>(address).sin_addr;
  if (address.sa_family == AF_INET6) bytes = &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  if (bytes == nullptr || ::inet_ntop(address.sa_family, bytes, text.data(), text.size()) == nullptr) return {};
  return text.data();
}

}  // namespace

std::vector<NetworkLink> network_links() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  std::map<int, NetworkLink> links;
  for (const ifaddrs* at = list; at != nullptr; at = at->ifa_next) {
    const int index = static_cast<int>(::if_nametoindex(at->ifa_name));
    NetworkLink& link = links[index];
    link.index = index;
    link.name = at->ifa_name;
    link.on = (at->ifa_flags & IFF_UP) != 0;
    link.has_multicast = (at->ifa_flags & IFF_MULTICAST) != 0;
    link.up = (at->ifa_flags & IFF_UP) != 0 && (at->ifa_flags & IFF_RUNNING) != 0;
    link.is_loopback = (at->ifa_flags & IFF_LOOPBACK) != 0;
    if (at->ifa_addr == nullptr) continue;
    if (std::string text = text_of(*at->ifa_addr); !text.empty()) link.addresses.push_back(std::move(text));
  }
  ::freeifaddrs(list);
  links.erase(0);  // gone between the two questions
  std::vector<NetworkLink> all;
  for (auto& [index, link] : links) {
    std::sort(link.addresses.begin(), link.addresses.end());
    all.push_back(std::move(link));
  }
  return all;
}

std::vector<std::string> addresses_on_the_lan() {
  std::vector<std::string> first, rest;
  for (const NetworkLink& link : network_links()) {
    if (link.is_loopback || !link.on) continue;
    for (const std::string& address : link.addresses) {
      if (address.find(':') == std::string::npos) (link.has_multicast ? first : rest).push_back(address);
    }
  }
  first.insert(first.end(), rest.begin(), rest.end());
  return first;
}

LinkWatch::LinkWatch() : fd_(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)) {
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV6_IFADDR;
  if (fd_ < 0 || ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  ::close(fd_);
  fd_ = -1;
}

LinkWatch::~LinkWatch() {
  if (fd_ >= 0) ::close(fd_);
}

// The notifications are not parsed: after any, or after a loss (ENOBUFS), the complete state is read from the kernel.
void LinkWatch::drain() const {
  std::array<char, 8192> ignored{};
  ssize_t got = 0;
  do {
    got = ::recv(fd_, ignored.data(), ignored.size(), MSG_DONTWAIT);
  } while (got > 0 || (got < 0 && (errno == ENOBUFS || errno == EINTR)));
}

}  // namespace nacelle::networking
