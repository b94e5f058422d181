// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::control {

/// A running container of another user, which this user cannot ask.
struct OthersContainer {
  std::string name;
  unsigned user = 0;
  std::string runtime_dir;  ///< The XDG_RUNTIME_DIR that its user has; empty: its socket is in /tmp.
  friend bool operator==(const OthersContainer&, const OthersContainer&) = default;
};

/// Returns the containers of other users among the sockets of this machine. `sockets`: the text of /proc/net/unix, which shows
/// the paths of all users. What is no name of a container is left out. Pure.
[[nodiscard]] std::vector<OthersContainer> containers_of_others(std::string_view sockets, unsigned own_user);

/// Returns what to tell a user who has no running container while others have: whose they are, and how to ask them.
/// `others` is not empty.
[[nodiscard]] Problem problem_of_others(const std::vector<OthersContainer>& others);

}  // namespace nacelle::control
