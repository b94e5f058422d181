// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "doctor/machine.hpp"

namespace nacelle::doctor {

/// The people of /etc/passwd who can log in, but for root and `user`: in mode `local` each of them can do to a robot what its
/// owner can. Accounts of services, below UID_MIN or without a shell, are left out. Sorted.
[[nodiscard]] std::vector<std::string> other_login_users(const Machine& machine, uid_t user);

}  // namespace nacelle::doctor
