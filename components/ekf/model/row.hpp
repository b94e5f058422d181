// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "ekf/model/state.hpp"

namespace nacelle::ekf {

/// One padded row of a covariance, kept in registers while sums run over it. Two doubles are the width that both SSE2 and
/// NEON have; the compiler's own vectoriser does not keep rows in registers across such loops.
struct alignas(16) Row {
  using Pair = double __attribute__((vector_size(16)));
  static constexpr int kPairs = StateCovariance::kStride / 2;
  Pair pair[kPairs];

  [[nodiscard]] static Row load(const double* from) {
    Row row;
    std::memcpy(row.pair, __builtin_assume_aligned(from, 16), sizeof row.pair);
    return row;
  }
  [[nodiscard]] static Row zero() { return Row{}; }
  void store(double* to) const { std::memcpy(__builtin_assume_aligned(to, 16), pair, sizeof pair); }
  [[nodiscard]] double operator[](int i) const { return pair[i / 2][i % 2]; }

  /// this += a x, over the first `Count` pairs.
  template <int Count = kPairs>
  void add(double a, const Row& x) {
    const Pair both{a, a};
    for (int p = 0; p < Count; ++p) pair[p] += both * x.pair[p];
  }
  template <int Count = kPairs>
  void subtract(double a, const Row& x) {
    const Pair both{a, a};
    for (int p = 0; p < Count; ++p) pair[p] -= both * x.pair[p];
  }
  void scale(double a) {
    const Pair both{a, a};
    for (Pair& p : pair) p *= both;
  }
};

}  // namespace nacelle::ekf
