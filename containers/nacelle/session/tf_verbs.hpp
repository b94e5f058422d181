// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nacelle/base/time.hpp"
#include "nacelle/node/message.hpp"

namespace nacelle::session {

class Session;

/// The type of /tf's messages.
inline constexpr const char* kTransformsType = "tf2_msgs/msg/TFMessage";

/// Answers "tf.tree" (every edge with owner, rate and age) and "tf.lookup" (target, source: the latest transform, or why there
/// is none). Another verb is no verb of this family: null.
/// Threads: the main thread.
[[nodiscard]] nlohmann::json reply_to_tf_verb(Session& session, const std::string& verb, const nlohmann::json& request);

/// For `tf monitor`: a message of kTransformsType as [[child, parent, stamp_ns, published_ns], ...], both by the wall clock.
void append_transform_times(std::string& out, const Block& block, const Clock& clock);

}  // namespace nacelle::session
