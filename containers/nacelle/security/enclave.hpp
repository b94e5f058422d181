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

/// An enclave that a participant can be made with.
struct Enclave {
  transport_dds::SecuredBy secured;
  std::vector<Problem> remarks;  ///< What is weaker than it should be.
};

/// Reads all files of the enclave that is asked for, and finds what would keep the plugins from using them, or others
/// from believing them: a file that is missing, cannot be read or is another one; a key that is not the certificate's;
/// signatures of another authority; times that are over or have not begun; documents of another domain.
/// Errors: the first of that, a SecurityFault, a FileFault or a NameFault, with the file and the way out. Threads: any.
[[nodiscard]] Result<Enclave, Problem> open_enclave(const transport_dds::SecurityWish& wish, int domain, WallTime now);

}  // namespace nacelle::security
