// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

#include "nacelle/base/time.hpp"

namespace nacelle {

/// Counts durations in buckets of at most 12.5 % width, from 1 ns to 584 years.
///
/// Source:    log-linear buckets: 3 mantissa bits below the leading one.
/// Threads:   one writer at a time; readers from any thread see each bucket whole, the sum of them perhaps mid-update.
/// Allocates: nothing; 2 kB.
class DurationHistogram {
 public:
  void record(Duration value) {
    const auto ns = value.count() > 0 ? static_cast<std::uint64_t>(value.count()) : 0;
    bump(buckets_[index_of(ns)]);
    if (ns > max_ns_.load(std::memory_order_relaxed)) max_ns_.store(ns, std::memory_order_relaxed);
  }

  [[nodiscard]] std::uint64_t count() const {
    std::uint64_t n = 0;
    for (const auto& bucket : buckets_) n += bucket.load(std::memory_order_relaxed);
    return n;
  }
  /// The upper edge of the bucket that holds the given share (0 to 1) of the values; zero when empty.
  [[nodiscard]] Duration quantile(double share) const;
  [[nodiscard]] Duration max() const {
    return Duration{static_cast<std::int64_t>(max_ns_.load(std::memory_order_relaxed))};
  }
  /// The sum of the values, each taken as the middle of its bucket: within 6.25 %.
  [[nodiscard]] Duration total() const;
  /// Values above a limit; those in the limit's own bucket do not count, so up to 12.5 % above it pass.
  [[nodiscard]] std::uint64_t count_above(Duration limit) const {
    std::uint64_t n = 0;
    const auto ns = limit.count() > 0 ? static_cast<std::uint64_t>(limit.count()) : 0;
    for (std::size_t i = index_of(ns) + 1; i < kBuckets; ++i) n += buckets_[i].load(std::memory_order_relaxed);
    return n;
  }
  /// Adds the counts of another histogram. Threads: as record().
  void merge(const DurationHistogram& other);
  void clear();

 private:
  static constexpr unsigned kMantissaBits = 3;
  static constexpr std::size_t kBuckets = 64U << kMantissaBits;

  static std::size_t index_of(std::uint64_t ns) {
    // The leading one is not taken off the mantissa: it is the step from one exponent's buckets to the next's. What is smaller
    // than all mantissas is its own bucket.
    const auto shift = static_cast<unsigned>(std::bit_width(ns | (1U << kMantissaBits))) - 1 - kMantissaBits;
    return static_cast<std::size_t>((std::uint64_t{shift} << kMantissaBits) + (ns >> shift));
  }
  static std::uint64_t upper_edge(std::size_t index);
  // One writer: a load and a store cost less than a locked add.
  static void bump(std::atomic<std::uint32_t>& bucket) {
    bucket.store(bucket.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint32_t>, kBuckets> buckets_{};
  std::atomic<std::uint64_t> max_ns_{0};
};

}  // namespace nacelle
