// SPDX-License-Identifier: Apache-2.0
#include "support/own_network.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace nacelle::test {
namespace {
bool has_own_network = false;

// Fast DDS has shared memory for each participant, named after the domain, and leaves it behind when its process is killed.
void enter_own_shared_memory() {
  if (::unshare(CLONE_NEWNS) != 0) return;
  // In a chroot, / is no mount of its own.
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 &&
      ::mount(nullptr, "/dev/shm", nullptr, MS_PRIVATE, nullptr) != 0)
    return;
  static_cast<void>(::mount("tmpfs", "/dev/shm", "tmpfs", MS_NOSUID | MS_NODEV, "mode=1777"));
}

}  // namespace

bool enter_own_network() {
  // Who is not root may have one together with a user namespace.
  if (::unshare(CLONE_NEWNET) != 0 && ::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  has_own_network = true;
  enter_own_shared_memory();
  // The kernel gives a port of its own choice to each sender; none of those that the domains of tests have (100 to 199).
  if (std::FILE* const range = std::fopen("/proc/sys/net/ipv4/ip_local_port_range", "we"); range != nullptr) {
    static_cast<void>(std::fputs("58000 65000", range));
    static_cast<void>(std::fclose(range));
  }
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return false;
  ifreq loopback{};
  std::strncpy(loopback.ifr_name, "lo", IFNAMSIZ - 1);
  bool up = ::ioctl(socket, SIOCGIFFLAGS, &loopback) == 0;
  loopback.ifr_flags = static_cast<short>(loopback.ifr_flags | IFF_UP | IFF_RUNNING | IFF_MULTICAST);
  up = up && ::ioctl(socket, SIOCSIFFLAGS, &loopback) == 0;
  ::close(socket);
  return up;
}

bool add_to_loopback(const char* address) {
  static int next = 0;
  if (!has_own_network) return false;
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return false;
  ifreq alias{};
  std::snprintf(alias.ifr_name, sizeof alias.ifr_name, "lo:%d", next++);
  auto& to = reinterpret_cast<sockaddr_in&>(alias.ifr_addr);
  to.sin_family = AF_INET;
  const bool added = ::inet_pton(AF_INET, address, &to.sin_addr) == 1 &&
                     (::ioctl(socket, SIOCSIFADDR, &alias) == 0 || errno == EEXIST);
  ::close(socket);
  return added;
}

bool add_lan(const char* address) {
  if (!has_own_network) return false;
  const std::string give = "ip link add home0 type veth peer name far0 && ip addr add " + std::string(address) +
                           "/24 dev home0 && ip link set home0 up && ip link set far0 up";
  return std::system(give.c_str()) == 0;
}

}  // namespace nacelle::test
