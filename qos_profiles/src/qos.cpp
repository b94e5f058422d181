// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/qos.hpp"

#include <algorithm>

#include "nacelle/base/expect.hpp"

namespace nacelle {

QoS& QoS::keep_last(std::size_t depth) {
  history_ = History::KeepLast;
  depth_ = depth;
  return *this;
}

QoS& QoS::keep_all() {
  history_ = History::KeepAll;
  depth_ = 0;
  return *this;
}

QoS& QoS::max_blocking_time(Duration value) {
  NACELLE_EXPECT(value >= Duration::zero(), "a blocking time is not negative");
  max_blocking_time_ = value;
  return *this;
}

std::size_t QoS::queue_capacity() const { return std::max<std::size_t>(1, keeps_all() ? max_samples_ : depth_); }

QoS QoS::resolved() const {
  QoS q = *this;
  if (q.history_ == History::SystemDefault) q.history_ = History::KeepLast;
  if (q.history_ == History::KeepLast && q.depth_ == 0) q.depth_ = 1;
  if (q.reliability_ == Reliability::SystemDefault) q.reliability_ = Reliability::Reliable;
  if (q.durability_ == Durability::SystemDefault) q.durability_ = Durability::Volatile;
  if (q.liveliness_ == Liveliness::SystemDefault) q.liveliness_ = Liveliness::Automatic;
  return q;
}

Duration QoS::checked(Duration value) {
  NACELLE_EXPECT(value >= Duration::zero(), "a QoS duration is not negative");
  return value == Duration::max() ? Duration::zero() : value;
}

}  // namespace nacelle
