// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::control {

/// A running container of another user, which this user cannot query.
struct OthersContainer {
  std::string name;
  unsigned user = 0;
  std::string runtime_dir;  ///< The user's XDG_RUNTIME_DIR; empty: the socket is in /dev/shm.
  bool is_service = false;  ///< Of nacelle@NAME.service, in /run/nacelle; its user is not known.
  friend bool operator==(const OthersContainer&, const OthersContainer&) = default;
};

/// Returns the containers of other users among the sockets of this machine. `sockets`: the text of /proc/net/unix,
/// which lists the paths of all users. Other paths are left out. Pure.
[[nodiscard]] std::vector<OthersContainer> containers_of_others(std::string_view sockets, unsigned own_user);

/// Returns the problem of a user who has no running container while other users have some. It names these users, and
/// the command that queries their containers or gives access to that of a service. `others` must not be empty.
[[nodiscard]] Problem problem_of_others(const std::vector<OthersContainer>& others);

}  // namespace nacelle::control
