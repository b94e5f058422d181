// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::control {

/// The candidate folders of control sockets. main() takes them from the environment, tests supply their own.
struct SocketPlaces {
  std::string xdg_runtime_dir;  ///< Empty: not set.
  std::string system_dir = "/run/nacelle";
  std::string fallback_dir;  ///< /dev/shm/nacelle-<uid>: RAM, unlike /tmp on many machines.
};
[[nodiscard]] SocketPlaces socket_places_from_environment();

/// Accepts 1 to 48 letters, digits, '_', '-' and '.', not beginning with '.'.
[[nodiscard]] Result<void, Problem> validate_container_name(const std::string& name);

/// Returns the folder for a new socket: the first of $XDG_RUNTIME_DIR/nacelle, /run/nacelle and /dev/shm/nacelle-<uid>
/// that is trusted (trust.hpp) and writable for this user. Creates the two that are a user's own (mode 0700).
[[nodiscard]] Result<std::string, Problem> folder_for_socket(const SocketPlaces& places);

/// Returns the socket's path for a container of that name. Errors: as folder_for_socket().
[[nodiscard]] Result<std::string, Problem> socket_path_of(const SocketPlaces& places, const std::string& name);

/// A socket of a container that may be running.
struct FoundContainer {
  std::string name, path;
  friend bool operator==(const FoundContainer&, const FoundContainer&) = default;
};
/// Returns every container that accepts connections, sorted by name. Leaves out a socket without a listener (its
/// container was killed). Leaves out a folder or socket that is not trusted (trust.hpp), and never connects to it;
/// `ignored` gets one Problem for each folder with such an entry.
[[nodiscard]] std::vector<FoundContainer> running_containers(const SocketPlaces& places,
                                                             std::vector<Problem>* ignored = nullptr);

/// Returns the named container, or the only one. Errors: NameFault::Unknown, Ambiguous. Pure.
[[nodiscard]] Result<FoundContainer, Problem> choose_container(const std::vector<FoundContainer>& running,
                                                               const std::optional<std::string>& wanted);

/// Claims a name: holds its lock and the listening socket. The destructor removes both.
class SocketClaim {
 public:
  /// Errors: the name is invalid or in use by a living container, or the folder cannot be used.
  [[nodiscard]] static Result<SocketClaim, Problem> take(const SocketPlaces& places, const std::string& name);
  SocketClaim(SocketClaim&& other) noexcept;
  SocketClaim& operator=(SocketClaim&&) = delete;
  ~SocketClaim();

  [[nodiscard]] int listening_descriptor() const { return listen_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Returns the group whose members may also connect: that of the system folder. Nothing in a user's own folder.
  [[nodiscard]] std::optional<gid_t> group() const { return group_; }

 private:
  SocketClaim() = default;
  int lock_ = -1, listen_ = -1;
  std::string path_, lock_path_;
  std::optional<gid_t> group_;
};

}  // namespace nacelle::control
