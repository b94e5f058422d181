// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::security {

/// Returns a policy file in which each `<xi:include href="common/node.xml" xpointer="xpointer(/profile/*)"/>` is
/// replaced by the included elements: the file's root, or the elements at the path of names.
/// Names of files are relative to the including file. A file without includes is returned unchanged.
/// Errors: a FileFault or a PolicyFault; the latter also for another form of xpointer and for more than eight nested
/// files.
[[nodiscard]] Result<std::string, Problem> read_with_includes(const std::filesystem::path& file);

}  // namespace nacelle::security
