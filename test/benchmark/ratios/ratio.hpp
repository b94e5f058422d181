// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace nacelle::bench {

/// Two sides of one comparison, measured in turn in the same run (A B B A ...), and the medians of their blocks.
struct Ratio {
  double a_ns = 0, b_ns = 0;
  [[nodiscard]] double value() const { return b_ns > 0 ? a_ns / b_ns : 0; }
};

template <typename T>
[[nodiscard]] T median(std::vector<T> values) {
  if (values.empty()) return T{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// `a` and `b` measure one block each and return nanoseconds.
template <typename A, typename B>
[[nodiscard]] Ratio interleave(std::uint64_t blocks, A a, B b) {
  std::vector<double> as, bs;
  a(), b();  // warm both
  for (std::uint64_t i = 0; i < blocks; ++i) {
    if (i % 2 == 0) {
      as.push_back(a());
      bs.push_back(b());
    } else {
      bs.push_back(b());
      as.push_back(a());
    }
  }
  return {median(as), median(bs)};
}

/// Cost of one message of `large` bytes beside one of `small` bytes, one reader, one thread; nothing is filled.
[[nodiscard]] Ratio compare_sizes(std::uint64_t small, std::uint64_t large, std::uint64_t blocks);
/// Median round trip of two components on threads of their own (a) beside that of two threads and a futex (b), the threads bound
/// to these CPUs.
[[nodiscard]] Ratio compare_wake(int first_cpu, int second_cpu, std::uint64_t blocks);

}  // namespace nacelle::bench
