// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

namespace nacelle::control {

/// The purpose of a folder of sockets, which determines its required owner and mode.
enum class FolderKind : std::uint8_t {
  Private,  ///< One user's: owned by this user or root, mode 0700.
  /// Below /run: owned by root, or by the user to whom root gave it (a service's), mode 0750; its sockets have its group and mode
  /// 0660.
  System,
};

/// Returns why a folder is not trusted; nothing if it is. Does not follow symbolic links.
[[nodiscard]] std::optional<std::string> distrust_of_folder(const std::string& folder, FolderKind kind);
/// Returns why a socket in a trusted folder is not trusted; nothing if it is.
[[nodiscard]] std::optional<std::string> distrust_of_socket(const std::string& path, FolderKind kind);

/// The process at the other end of a connected UNIX socket, as reported by the kernel.
struct Peer {
  pid_t process = 0;
  uid_t user = 0;
  gid_t group = 0;
};
[[nodiscard]] std::optional<Peer> peer_of(int socket);

/// Returns whether a container accepts the peer: this user, root, or a member of `group` (supplementary groups
/// included).
/// Allocates: only if the peer's user alone does not decide.
[[nodiscard]] bool may_ask(int socket, const Peer& peer, std::optional<gid_t> group);
/// Returns whether a command may use the container at the other end: it runs as this user or root, or in a folder of the system
/// in which only its user, or root, can write.
[[nodiscard]] bool may_answer(const Peer& peer, const std::string& path);

}  // namespace nacelle::control
