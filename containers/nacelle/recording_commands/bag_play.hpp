// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "cli/whom.hpp"

namespace nacelle::cli {

struct BagPlayWish {
  Whom whom;
  std::string path, regex, exclude_regex, name = "rosbag2_player";
  std::vector<std::string> topics, exclude_topics, remaps;
  double rate = 1.0, clock_hz = 0.0, start_offset_s = 0.0, duration_s = 0.0;
  bool loop = false, start_paused = false;
};

/// Loads a player into the container (into one of its own if none runs), shows its progress until the recording's end or Ctrl-C, and unloads it. Returns the exit code.
int play_bag(const BagPlayWish& asked);

}  // namespace nacelle::cli
