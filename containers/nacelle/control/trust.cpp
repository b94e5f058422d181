// SPDX-License-Identifier: Apache-2.0
#include "control/trust.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

namespace nacelle::control {
namespace {

constexpr uid_t kRoot = 0;

bool is_own_or_root(uid_t user) { return user == ::geteuid() || user == kRoot; }

std::string folder_above(const std::string& path) { return path.substr(0, path.rfind('/')); }

/// Only root makes entries in a folder that only root may write, as in /run: an entry of another user is there because root wants it.
bool is_made_by_root(const std::string& path) {
  struct stat above {};
  return ::lstat(folder_above(path).c_str(), &above) == 0 && S_ISDIR(above.st_mode) && above.st_uid == kRoot &&
         (above.st_mode & 0022U) == 0;
}

}  // namespace

std::optional<std::string> distrust_of_folder(const std::string& folder, FolderKind kind) {
  struct stat seen {};
  // lstat: in /dev/shm, a symbolic link of that name may be another user's trap.
  if (::lstat(folder.c_str(), &seen) != 0) return std::strerror(errno);
  if (!S_ISDIR(seen.st_mode)) return "not a folder";
  const bool is_system = kind == FolderKind::System;
  if (is_system ? seen.st_uid != kRoot && !is_made_by_root(folder) : !is_own_or_root(seen.st_uid))
    return fmt::format("owned by user {}", seen.st_uid);
  if ((seen.st_mode & (is_system ? 0027U : 0077U)) != 0)
    return fmt::format("open to other users (chmod {} it)", is_system ? "750" : "700");
  return std::nullopt;
}

std::optional<std::string> distrust_of_socket(const std::string& path, FolderKind kind) {
  struct stat seen {};
  if (::lstat(path.c_str(), &seen) != 0) return std::strerror(errno);
  if (!S_ISSOCK(seen.st_mode)) return "not a socket";
  // Only its owner and root create files in a system folder.
  if (kind == FolderKind::Private && !is_own_or_root(seen.st_uid)) return fmt::format("owned by user {}", seen.st_uid);
  // To connect is to write.
  if ((seen.st_mode & (kind == FolderKind::System ? 0002U : 0022U)) != 0) return "open to other users";
  return std::nullopt;
}

std::optional<Peer> peer_of(int socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0 || size != sizeof peer) return std::nullopt;
  return Peer{peer.pid, peer.uid, peer.gid};
}

bool may_ask(int socket, const Peer& peer, std::optional<gid_t> group) {
  if (is_own_or_root(peer.user)) return true;
  if (!group) return false;
  if (peer.group == *group) return true;
  std::vector<gid_t> groups(32);
  auto size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) != 0) {
    if (errno != ERANGE) return false;
    groups.resize(size / sizeof(gid_t));  // the kernel has returned their number
    if (::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) != 0) return false;
  }
  groups.resize(size / sizeof(gid_t));
  return std::ranges::find(groups, *group) != groups.end();
}

bool may_answer(const Peer& peer, const std::string& path) {
  if (is_own_or_root(peer.user)) return true;
  struct stat folder {};
  const std::string above = folder_above(path);
  if (::lstat(above.c_str(), &folder) != 0 || !S_ISDIR(folder.st_mode) || (folder.st_mode & 0022U) != 0) return false;
  if (folder.st_uid == kRoot) return true;
  return folder.st_uid == peer.user && !distrust_of_folder(above, FolderKind::System);
}

}  // namespace nacelle::control
