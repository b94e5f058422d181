// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nacelle::cli {

struct BagDiffWish {
  std::string a, b;
  std::string tolerance;            ///< A file; empty: all values must be equal.
  std::vector<std::string> topics;  ///< Empty: all.
  bool as_json = false;
};

/// Compares two recordings and prints what differs. Returns the exit code, as diff(1) does: 0 if they are equal, 1 if they differ, 2 if they
/// cannot be compared.
int diff_bags(const BagDiffWish& wish);

}  // namespace nacelle::cli
