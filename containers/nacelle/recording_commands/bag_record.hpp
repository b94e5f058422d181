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
  std::string ring, ring_size = "64MB";  ///< "60s"; empty: no ring.
  bool all = false, hidden = false, start_paused = false;
};

/// Loads a recorder into the container, shows its progress until Ctrl-C or the wish's end, and unloads it, so that the recording is complete.
/// Returns the exit code: kFailed if the recording ended by itself.
int record_bag(const BagRecordWish& wish);

struct BagSnapshotWish {
  Whom whom;
  std::string node = "rosbag2_recorder";
};

/// Lets a recorder write its ring, and prints the folder. Returns the exit code.
int snapshot_bag(const BagSnapshotWish& wish);

/// Return what is wrong with a text, or nothing: "60s", of a second or more; "64MB", of 1 MB or more.
[[nodiscard]] std::string wrong_ring(const std::string& text);
[[nodiscard]] std::string wrong_ring_size(const std::string& text);

}  // namespace nacelle::cli
