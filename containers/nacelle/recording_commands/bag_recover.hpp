// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::cli {

struct BagRecoverWish {
  std::string file, output;
  std::string compression = "none";
};

/// Copies what can be read of a file into a new one. Returns the exit code.
int recover_bag(const BagRecoverWish& wish);

}  // namespace nacelle::cli
