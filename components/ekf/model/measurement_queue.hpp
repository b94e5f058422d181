// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "ekf/model/update.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

struct Measurement {
  WallTime stamp{};
  std::uint16_t part{};  ///< Which part of which input, for the counters.
  Reading reading;
};

/// Measurements in the order of their stamps, those of one stamp in the order of their arrival.
/// Threads: one. Allocates: in the constructor only.
class MeasurementQueue {
 public:
  explicit MeasurementQueue(std::size_t capacity);

  [[nodiscard]] bool empty() const { return order_.empty(); }
  [[nodiscard]] std::size_t size() const { return order_.size(); }
  [[nodiscard]] bool full() const { return free_.empty(); }

  /// A place to fill; follow with push() or give_back(). Must not be full.
  [[nodiscard]] Measurement& reserve();
  void push(Measurement& filled);
  void give_back(Measurement& unused);

  /// The oldest; valid until it is popped. Must not be empty.
  [[nodiscard]] const Measurement& oldest() const { return slots_[order_.front().slot]; }
  void pop_oldest();
  /// The newest, for eviction when the future has filled the queue. Linear. Must not be empty.
  [[nodiscard]] const Measurement& newest() const;
  void pop_newest();
  void clear();

 private:
  struct Entry {
    std::int64_t stamp_ns;
    std::uint64_t arrival;
    std::uint32_t slot;
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.stamp_ns != b.stamp_ns ? a.stamp_ns > b.stamp_ns : a.arrival > b.arrival;
  }
  [[nodiscard]] std::size_t newest_entry() const;

  std::vector<Measurement> slots_;
  std::vector<std::uint32_t> free_;
  std::vector<Entry> order_;  // a heap, oldest first
  std::uint64_t arrivals_{0};
};

}  // namespace nacelle::ekf
