// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/edge_counter.hpp"

#include <cstdint>

namespace nacelle::diff_drive {

void EdgeCounter::begin(bool a, bool b) {
  a_ = {a};
  b_ = {b};
}

void EdgeCounter::edge(Channel channel, bool level, std::uint32_t number, MonotonicTime at, bool is_merged) {
  Line& line = channel == Channel::A ? a_ : b_;
  const std::uint32_t ahead = number - line.number - 1U;
  // A number of before is none that is ahead by almost all there are.
  const std::uint32_t missing = ahead > INT32_MAX ? 0U : ahead;
  line.number = number;
  lost_ += missing;
  count_ += direction_ * static_cast<std::int64_t>(missing);

  ++edges_;
  const bool is_new = level != line.level;
  line.level = level;
  line.is_known = true;
  // Behind an odd number of missing edges the level is the one that was known, and the edge counts all the same. Without any, a spike
  // was too short for its second edge.
  if (!is_new && missing == 0) {
    if (!is_merged) return;
    ++lost_;
    count_ += direction_;
  }
  if (has_b_ && a_.is_known && b_.is_known) direction_ = (channel == Channel::A) == (a_.level != b_.level) ? 1 : -1;
  count_ += direction_;
  edge_at_ = at;
}

void EdgeCounter::drive(int direction) {
  if (!has_b_ && direction != 0) direction_ = direction;
}

}  // namespace nacelle::diff_drive
