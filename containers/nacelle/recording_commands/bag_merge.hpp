// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nacelle::cli {

struct BagMergeWish {
  std::vector<std::string> paths;
  std::string output;
  std::string compression = "none";
};

/// Copies several recordings into a new file, in the order of their log times. Returns the exit code: kFailed if something cannot be read
/// or written, or two recordings give a topic different types.
int merge_bags(const BagMergeWish& wish);

}  // namespace nacelle::cli
