// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::record {

/// Returns the files of a recording: the file itself, or those with the ending .mcap or .db3 (but not both) in a folder that `ros2 bag record`
/// made, in the order of the numbers in their names. Errors: a FileFault; `where` is the path.
[[nodiscard]] Result<std::vector<std::string>, Problem> recording_files(const std::string& path);

/// Makes the folder of a new recording, and those above it. Errors: a FileFault; `where` is the path. One that exists is never touched.
[[nodiscard]] std::optional<Problem> make_recording_folder(const std::string& path);

}  // namespace nacelle::record
