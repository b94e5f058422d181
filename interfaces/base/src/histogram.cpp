// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/histogram.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle {

std::uint64_t DurationHistogram::upper_edge(std::size_t index) {
  if (index < (1U << kMantissaBits)) return index;
  const auto exponent = (index >> kMantissaBits) + kMantissaBits - 1;
  const auto mantissa = (index & ((1U << kMantissaBits) - 1)) | (1U << kMantissaBits);
  return (static_cast<std::uint64_t>(mantissa + 1) << (exponent - kMantissaBits)) - 1;
}

Duration DurationHistogram::quantile(double share) const {
  const std::uint64_t total = count();
  if (total == 0) return Duration::zero();
  const auto rank = static_cast<std::uint64_t>(std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(total)));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    seen += buckets_[i].load(std::memory_order_relaxed);
    if (seen >= std::max<std::uint64_t>(rank, 1)) {
      return std::min(Duration{static_cast<std::int64_t>(upper_edge(i))}, max());
    }
  }
  return max();
}

Duration DurationHistogram::total() const {
  const auto most_ns = static_cast<double>(max().count());
  double sum_ns = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    const std::uint64_t n = buckets_[i].load(std::memory_order_relaxed);
    if (n == 0) continue;
    const double lower = i == 0 ? 0.0 : static_cast<double>(upper_edge(i - 1) + 1);
    sum_ns += static_cast<double>(n) * std::min((lower + static_cast<double>(upper_edge(i))) / 2, most_ns);
  }
  // The nearest double to the longest duration is beyond it.
  return sum_ns < static_cast<double>(Duration::max().count()) ? Duration{static_cast<std::int64_t>(sum_ns)}
                                                               : Duration::max();
}

void DurationHistogram::merge(const DurationHistogram& other) {
  for (std::size_t i = 0; i < kBuckets; ++i) {
    buckets_[i].fetch_add(other.buckets_[i].load(std::memory_order_relaxed), std::memory_order_relaxed);
  }
  if (other.max() > max()) max_ns_.store(static_cast<std::uint64_t>(other.max().count()), std::memory_order_relaxed);
}

void DurationHistogram::clear() {
  for (auto& bucket : buckets_) bucket.store(0, std::memory_order_relaxed);
  max_ns_.store(0, std::memory_order_relaxed);
}

}  // namespace nacelle
