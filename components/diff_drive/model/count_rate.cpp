// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/count_rate.hpp"

#include <algorithm>

namespace nacelle::diff_drive {

double CountRate::update(std::int64_t count, std::optional<MonotonicTime> edge_at, MonotonicTime now) {
  if (!has_last_) {
    has_last_ = true;
    last_count_ = count;
    last_at_ = now;
    last_edge_at_ = edge_at.value_or(now);
    rate_ = 0.0;
    return rate_;
  }
  const auto moved = static_cast<double>(count - last_count_);
  if (!edge_at) {
    if (now > last_at_) rate_ = moved / to_seconds(now - last_at_);
  } else if (moved != 0.0) {
    // The last edge before a wheel stood says nothing of how it turns now.
    const MonotonicTime since = rate_ == 0.0 ? std::max(last_edge_at_, last_at_) : last_edge_at_;
    if (*edge_at > since) rate_ = moved / to_seconds(*edge_at - since);
    last_edge_at_ = *edge_at;
  } else if (now - last_edge_at_ > kStandsAfter) {
    rate_ = 0.0;
  } else if (now > last_edge_at_) {
    const double most = 1.0 / to_seconds(now - last_edge_at_);
    rate_ = std::clamp(rate_, -most, most);
  }
  last_count_ = count;
  last_at_ = now;
  return rate_;
}

}  // namespace nacelle::diff_drive
