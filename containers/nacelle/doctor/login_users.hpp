// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "doctor/machine.hpp"

namespace nacelle::doctor {

/// Returns the users of /etc/passwd that can log in, except root and `user`, sorted. In mode `local` each of them can
/// control a robot as its owner can. Leaves out service accounts: those with a UID below 1000, `nobody`, and those
/// whose shell refuses a login.
[[nodiscard]] std::vector<std::string> other_login_users(const Machine& machine, uid_t user);

}  // namespace nacelle::doctor
