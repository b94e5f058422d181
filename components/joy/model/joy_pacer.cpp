// SPDX-License-Identifier: Apache-2.0
#include "joy/model/joy_pacer.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::joy {

bool JoyPacer::on_change(PadState::Change change, MonotonicTime now) {
  if (change == PadState::Change::None) return is_due(now);
  if (change == PadState::Change::Button) return true;
  if (!std::exchange(waits_, true)) changed_ = now;
  return is_due(now);
}

void JoyPacer::on_published(MonotonicTime now) {
  waits_ = false;
  published_ = now;
}

MonotonicTime JoyPacer::next(MonotonicTime latest) const {
  if (waits_) latest = std::min(latest, changed_ + settings_.coalesce);
  if (settings_.repeat > Duration::zero()) latest = std::min(latest, published_ + settings_.repeat);
  return latest;
}

}  // namespace nacelle::joy
