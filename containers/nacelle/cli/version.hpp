// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::cli {

/// Returns the version and the commit that was built: "0.1.0 (0123456789ab)", "-dirty" behind the commit if files differed from it.
/// The commit is missing if the sources were neither a checkout nor an archive made by git.
[[nodiscard]] const char* program_version();

}  // namespace nacelle::cli
