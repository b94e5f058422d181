// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "transport_dds/wire/ros_environment.hpp"
#include "transport_dds/wire/security_files.hpp"

namespace nacelle::security {

/// A checked enclave for a participant.
struct Enclave {
  transport_dds::SecuredBy secured;
  std::vector<Problem> remarks;  ///< Weaknesses that do not prevent its use.
};

/// Reads all files of the requested enclave, and finds problems that would make the plugins or peers reject it: a
/// missing, unreadable or wrong file; a key that does not belong to the certificate; a signature of another authority;
/// times that have expired or not begun; documents for another domain.
/// Errors: the first problem, a SecurityFault, a FileFault or a NameFault, with the file and the way out. Threads: any.
[[nodiscard]] Result<Enclave, Problem> open_enclave(const transport_dds::SecurityWish& wish, int domain, WallTime now);

}  // namespace nacelle::security
