// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/whom.hpp"

namespace nacelle::cli {

struct BagRecordWish {
  Whom whom;
  std::vector<std::string> topics, exclude_topics;
  std::string regex, exclude_regex, output, storage = "mcap", compression = "none", name = "rosbag2_recorder";
  std::int64_t max_size = 0, max_duration_s = 0;
  double for_s = 0.0;
  bool all = false, hidden = false, start_paused = false;
};

/// Loads a recorder into the container, shows its progress until Ctrl-C or the wish's end, and unloads it, so that the recording is complete.
/// Returns the exit code: kFailed if the recording ended by itself.
int record_bag(const BagRecordWish& wish);

}  // namespace nacelle::cli
