// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Verbs of transforms. `container`: a name, or empty for the only one.
// Errors: as Nodes::ask_container(), and those listed.
namespace nacelle::ask {

/// Returns "frames", and the names that the launch file's namespace determines: "name_space", "tf_topic",
/// "frame_prefix". A frame is an object:
///
///   "child", "parent", "owner" (empty: unknown), "static", "rate_hz", "age_s", "history_s", "samples"; "clock_skew" if
///   there is one
[[nodiscard]] Result<nlohmann::json, Problem> list_frames(Nodes& nodes, const std::string& container);

/// Returns the latest transform from source to target: "stamp_ns", "translation_m", "rotation_xyzw", "rpy_rad".
/// Errors: no such transform, with the nearest frame name; no component collects transforms.
[[nodiscard]] Result<nlohmann::json, Problem> lookup_transform(Nodes& nodes, const std::string& container,
                                                               const std::string& target, const std::string& source);

}  // namespace nacelle::ask
