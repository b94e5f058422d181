// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/measurement_queue.hpp"

#include <algorithm>

#include "nacelle/base/expect.hpp"

namespace nacelle::ekf {

MeasurementQueue::MeasurementQueue(std::size_t capacity) : slots_(capacity) {
  NACELLE_EXPECT(capacity > 0, "a queue of measurements needs room for one");
  free_.reserve(capacity);
  order_.reserve(capacity);
  clear();
}

Measurement& MeasurementQueue::reserve() {
  NACELLE_EXPECT(!free_.empty(), "ask full() before reserve()");
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  return slots_[slot];
}

void MeasurementQueue::push(Measurement& filled) {
  const auto slot = static_cast<std::uint32_t>(&filled - slots_.data());
  order_.push_back({filled.stamp.nanoseconds(), arrivals_++, slot});
  std::push_heap(order_.begin(), order_.end(), later);
}

void MeasurementQueue::give_back(Measurement& unused) {
  free_.push_back(static_cast<std::uint32_t>(&unused - slots_.data()));
}

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

const Measurement& MeasurementQueue::newest() const { return slots_[order_[newest_entry()].slot]; }

void MeasurementQueue::pop_newest() {
  const std::size_t at = newest_entry();
  free_.push_back(order_[at].slot);
  order_[at] = order_.back();
  order_.pop_back();
  std::make_heap(order_.begin(), order_.end(), later);
}

void MeasurementQueue::clear() {
  order_.clear();
  free_.clear();
  for (std::size_t i = slots_.size(); i-- > 0;) free_.push_back(static_cast<std::uint32_t>(i));
}

}  // namespace nacelle::ekf
