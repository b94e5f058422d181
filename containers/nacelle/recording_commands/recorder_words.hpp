// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

namespace nacelle::cli {

/// Returns what Nacelle's recorder wrote at the end of the recording about all of it: "lost", "camera copies", and "lost in queue: /topic" for topics
/// that lost messages. Empty if the recording is not on this machine, has no end, or is another recorder's. Reads no messages.
[[nodiscard]] std::map<std::string, std::string> recorder_words(const std::string& path);

}  // namespace nacelle::cli
