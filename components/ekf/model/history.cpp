// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/history.hpp"

#include <algorithm>
#include <iterator>

#include "nacelle/base/expect.hpp"

namespace nacelle::ekf {
namespace {

constexpr std::size_t kFewest = 64;

bool comes_before(const Measurement& a, const Measurement& b) {
  return a.stamp != b.stamp ? a.stamp < b.stamp : a.part < b.part;
}

}  // namespace

History::History(const HistoryOptions& options) : options_(options) {
  options_.limit = std::max(options_.limit, kFewest);
  make_places(std::max(options_.expected, kFewest));
  begin({});
}

void History::make_places(std::size_t count) {
  // One more than the limit: the base keeps no measurement.
  const std::size_t most = options_.limit + 1;
  while (places_ < std::min(count, most)) {
    const std::size_t more = std::min(kChunk, most - places_);
    chunks_.push_back(std::make_unique<Entry[]>(more));
    free_.reserve(places_ + more);
    order_.reserve(places_ + more);
    for (std::size_t i = more; i-- > 0;) free_.push_back(static_cast<std::uint32_t>(places_ + i));
    places_ += more;
  }
}

bool History::make_place() {
  make_places(2 * places_);
  return !full();
}

void History::begin(const FilterState& base) {
  free_.insert(free_.end(), order_.begin(), order_.end());
  order_.clear();
  next_ = again_ = kNone;
  cutoff_ = {};
  take_place(0).after = base;
}

History::Entry& History::take_place(std::size_t i) {
  NACELLE_EXPECT(!free_.empty(), "ask full() before");
  order_.insert(order_.begin() + static_cast<std::ptrdiff_t>(i), free_.back());
  free_.pop_back();
  return at(i);
}

// Behind all that do not come after it.
std::size_t History::place_of(const Measurement& measurement) const {
  std::size_t low = 1;
  std::size_t high = size();
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (comes_before(measurement, at(middle).measurement)) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

bool History::comes_last(const Measurement& measurement) const {
  if (kept() == 0) return measurement.stamp >= base().stamp;
  return !comes_before(measurement, at(size() - 1).measurement);
}

void History::append(const Measurement& measurement, const Command& command, const FilterState& after) {
  Entry& entry = take_place(size());
  entry.after = after;
  entry.measurement = measurement;
  entry.command = command;
  entry.fresh = entry.late = false;
}

void History::insert(const Measurement& measurement) {
  NACELLE_EXPECT(kept() > 0, "what is older than the base has no place");
  const bool runs = pending();
  const std::size_t i = place_of(measurement);
  const Command command = i > 1 ? at(i - 1).command : at(i).command;
  const bool late = measurement.stamp < newest().stamp;
  Entry& entry = take_place(i);
  entry.measurement = measurement;
  entry.command = command;
  entry.fresh = true;
  entry.late = late;
  if (again_ != kNone && again_ >= i) ++again_;
  if (!runs) {
    next_ = i;
  } else if (i < next_) {
    ++next_;
    again_ = std::min(again_, i);
  }
}

bool History::passed_next() {
  at(next_).fresh = false;
  if (++next_ < size()) return false;
  next_ = again_;
  again_ = kNone;
  return true;
}

void History::passed_oldest() {
  if (next_ == 1) {
    static_cast<void>(passed_next());
    return;
  }
  at(1).fresh = false;
  if (again_ == 1 && ++again_ == next_) again_ = kNone;  // the running pass goes on from here
}

void History::trim(WallTime stamp) {
  cutoff_ = std::max(cutoff_, stamp - options_.length);
  std::size_t old = 0;
  const std::size_t due = std::min(next_, again_);
  while (old + 1 < size() && old + 1 < due && at(old + 1).after.stamp <= cutoff_) ++old;
  forget_oldest(old);
}

void History::drop_oldest() {
  NACELLE_EXPECT(kept() > 0 && !oldest_is_due(), "the state after it is to be known");
  forget_oldest(1);
  ++cut_short_;
}

void History::forget_oldest(std::size_t count) {
  if (count == 0) return;
  const auto end = order_.begin() + static_cast<std::ptrdiff_t>(count);
  free_.insert(free_.end(), order_.begin(), end);
  order_.erase(order_.begin(), end);
  if (next_ != kNone) next_ -= count;
  if (again_ != kNone) again_ -= count;
}

}  // namespace nacelle::ekf
