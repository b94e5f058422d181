// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ekf/model/update.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

struct Measurement {
  WallTime stamp{};
  std::uint16_t part{};  ///< Which part of which input, for the counters.
  std::uint32_t slot{};  ///< The queue's own.
  Reading reading;
};

/// Which of two measurements of one stamp comes first.
enum class Ties : std::uint8_t { ByArrival, ByPart };

/// Measurements in the order of their stamps, those of one stamp in the order of their arrival (or of their parts first).
///
/// Has as many places as were needed so far, and never more than its limit (2 kB each).
/// Threads: one. Allocates: in the constructor, and when more measurements wait than ever before.
class MeasurementQueue {
 public:
  explicit MeasurementQueue(std::size_t limit, Ties ties = Ties::ByArrival);

  [[nodiscard]] bool empty() const { return order_.empty(); }
  [[nodiscard]] std::size_t size() const { return order_.size(); }
  [[nodiscard]] std::size_t places() const { return places_; }
  /// No place is left, and the limit is reached.
  [[nodiscard]] bool full() const { return free_.empty() && places_ == limit_; }
  /// Makes at least so many places, or as many as the limit allows.
  void make_places(std::size_t count);

  /// A place to fill; follow with push() or give_back(). Must not be full.
  [[nodiscard]] Measurement& reserve();
  void push(Measurement& filled);
  void give_back(Measurement& unused);

  /// The oldest; valid until it is popped. Must not be empty.
  [[nodiscard]] const Measurement& oldest() const { return at(order_.front().slot); }
  void pop_oldest();
  /// The newest, for eviction when the future has filled the queue. Linear. Must not be empty.
  [[nodiscard]] const Measurement& newest() const;
  void pop_newest();

 private:
  static constexpr std::size_t kChunk = 64;
  // So that a robot of 150 measurements per second may be paused for 0.8 s without an allocation when it resumes.
  static constexpr std::size_t kAtFirst = 256;
  struct Entry {
    std::int64_t stamp_ns;
    std::uint64_t arrival;  // the part in front of it, with Ties::ByPart
    std::uint32_t slot;
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.stamp_ns != b.stamp_ns ? a.stamp_ns > b.stamp_ns : a.arrival > b.arrival;
  }
  [[nodiscard]] const Measurement& at(std::uint32_t slot) const { return chunks_[slot / kChunk][slot % kChunk]; }
  [[nodiscard]] Measurement& at(std::uint32_t slot) { return chunks_[slot / kChunk][slot % kChunk]; }
  [[nodiscard]] std::size_t newest_entry() const;

  std::vector<std::unique_ptr<Measurement[]>> chunks_;  // places stay where they are when there are more
  std::vector<std::uint32_t> free_;
  std::vector<Entry> order_;  // a heap, oldest first
  std::size_t limit_;
  std::size_t places_{0};
  std::uint64_t arrivals_{0};
  Ties ties_;
};

}  // namespace nacelle::ekf
