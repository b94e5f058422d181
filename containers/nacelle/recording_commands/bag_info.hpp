// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::cli {

struct BagInfoWish {
  std::string path;
  bool as_json = false;
};

/// Prints what a recording has. Returns the exit code: kFailed if a file cannot be read, or not to its end.
int print_bag_info(const BagInfoWish& wish);

}  // namespace nacelle::cli
