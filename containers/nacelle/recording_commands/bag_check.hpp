// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::cli {

struct BagCheckWish {
  std::string path;
  bool as_json = false;
};

/// Compares what a recording says of itself with what it has, and decodes each message. Returns the exit code: kFailed if something is
/// wrong.
int check_bag(const BagCheckWish& wish);

}  // namespace nacelle::cli
