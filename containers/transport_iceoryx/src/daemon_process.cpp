// SPDX-License-Identifier: Apache-2.0
#include "daemon_process.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "iceoryx_hoofs/platform/platform_settings.hpp"
#include "iceoryx_posh/iceoryx_posh_types.hpp"

namespace nacelle::transport_iceoryx {
namespace {

std::string socket_path() {
  return std::string(iox::platform::IOX_UDS_SOCKET_PATH_PREFIX) + iox::roudi::IPC_CHANNEL_ROUDI_NAME;
}
std::string lock_path() {
  return std::string(iox::platform::IOX_LOCK_FILE_PATH_PREFIX) + iox::roudi::IPC_CHANNEL_ROUDI_NAME + ".lock";
}

}  // namespace

int probe_daemon() {
  const int probe = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (probe < 0) return errno;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = socket_path();
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int status = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int error = status == 0 ? 0 : errno;
  ::close(probe);
  return error;
}

int holder_of(const std::string& locks, unsigned long inode, unsigned device_major, unsigned device_minor) {
  std::istringstream lines(locks);
  std::string line;
  int by_inode = 0, matches = 0;
  while (std::getline(lines, line)) {
    // "1: FLOCK  ADVISORY  WRITE 22384 fe:00:10952874 0 EOF". A process that waits for a lock has "->" behind the number.
    int pid = 0;
    unsigned major_number = 0, minor_number = 0;
    unsigned long file = 0;
    if (std::sscanf(line.c_str(), "%*d: FLOCK %*s WRITE %d %x:%x:%lu", &pid, &major_number, &minor_number, &file) != 4)
      continue;
    if (file != inode || pid <= 0) continue;
    if (major_number == device_major && minor_number == device_minor) return pid;
    by_inode = pid;
    ++matches;
  }
  // Some file systems (btrfs, overlayfs) tell stat() another device than the kernel's own table has.
  return matches == 1 ? by_inode : 0;
}

int open_daemon_process() {
  struct stat lock {};
  if (::stat(lock_path().c_str(), &lock) != 0) return -1;
  std::ifstream file("/proc/locks");
  const std::string locks{std::istreambuf_iterator<char>(file), {}};
  const int pid = holder_of(locks, lock.st_ino, major(lock.st_dev), minor(lock.st_dev));
  return pid == 0 ? -1 : static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
}

}  // namespace nacelle::transport_iceoryx
