// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/measurement_queue.hpp"

#include <algorithm>

#include "nacelle/base/expect.hpp"

namespace nacelle::ekf {

MeasurementQueue::MeasurementQueue(std::size_t limit, Ties ties) : limit_(limit), ties_(ties) {
  NACELLE_EXPECT(limit > 0, "a queue of measurements needs room for one");
  make_places(kAtFirst);
}

void MeasurementQueue::make_places(std::size_t count) {
  while (places_ < std::min(count, limit_)) {
    const std::size_t more = std::min(kChunk, limit_ - places_);
    chunks_.push_back(std::make_unique<Measurement[]>(more));
    free_.reserve(places_ + more);
    order_.reserve(places_ + more);
    for (std::size_t i = more; i-- > 0;) {
      const auto slot = static_cast<std::uint32_t>(places_ + i);
      chunks_.back()[i].slot = slot;
      free_.push_back(slot);
    }
    places_ += more;
  }
}

Measurement& MeasurementQueue::reserve() {
  if (free_.empty()) make_places(2 * places_);
  NACELLE_EXPECT(!free_.empty(), "ask full() before reserve()");
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  return at(slot);
}

void MeasurementQueue::push(Measurement& filled) {
  constexpr int kArrivalBits = 48;  // enough for nine years of a million measurements a second
  const std::uint64_t part = ties_ == Ties::ByPart ? std::uint64_t{filled.part} << kArrivalBits : 0;
  order_.push_back({filled.stamp.nanoseconds(), part | arrivals_++, filled.slot});
  std::push_heap(order_.begin(), order_.end(), later);
}

void MeasurementQueue::give_back(Measurement& unused) { free_.push_back(unused.slot); }

void MeasurementQueue::pop_oldest() {
  NACELLE_EXPECT(!order_.empty(), "nothing to pop");
  std::pop_heap(order_.begin(), order_.end(), later);
  free_.push_back(order_.back().slot);
  order_.pop_back();
}

std::size_t MeasurementQueue::newest_entry() const {
  NACELLE_EXPECT(!order_.empty(), "nothing waits");
  const auto last =
      std::max_element(order_.begin(), order_.end(), [](const Entry& a, const Entry& b) { return later(b, a); });
  return static_cast<std::size_t>(last - order_.begin());
}

const Measurement& MeasurementQueue::newest() const { return at(order_[newest_entry()].slot); }

void MeasurementQueue::pop_newest() {
  const std::size_t at = newest_entry();
  free_.push_back(order_[at].slot);
  order_[at] = order_.back();
  order_.pop_back();
  std::make_heap(order_.begin(), order_.end(), later);
}

}  // namespace nacelle::ekf
