// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::security {

/// A policy file with what it includes in the place of each `<xi:include href="common/node.xml"
/// xpointer="xpointer(/profile/*)"/>`: the file's root, or the elements that a path of names leads to.
/// Names are relative to the file that has them. A file without includes is given back as it is, with its lines.
/// Errors: a FileFault or a PolicyFault; the latter also for another form of xpointer and for more than eight files within each other.
[[nodiscard]] Result<std::string, Problem> read_with_includes(const std::filesystem::path& file);

}  // namespace nacelle::security
