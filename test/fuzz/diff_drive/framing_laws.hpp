// SPDX-License-Identifier: Apache-2.0
// The laws of each decoder of frames on a serial line. For any bytes, in any chopping: nothing crashes, every byte is accounted for, and
// the reports do not depend on the chopping.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

inline void require(bool holds) {
  if (!holds) std::abort();
}

/// counted_bytes(stats): the bytes that the decoder has put into one of its counters.
template <class Decoder, class Report, class CountedBytes>
void hold_laws(ByteView bytes, CountedBytes counted_bytes) {
  const auto require_accounted = [&](const Decoder& decoder) {
    require(decoder.stats().bytes == counted_bytes(decoder.stats()) + decoder.pending());
  };
  std::vector<Report> whole, chopped;
  Decoder at_once, in_parts;
  at_once.feed(bytes, [&](const Report& report) { whole.push_back(report); });
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - at, 1 + bytes[at] % 11U);
    in_parts.feed(bytes.subspan(at, part), [&](const Report& report) { chopped.push_back(report); });
    require_accounted(in_parts);
    at += part;
  }
  require(at_once.stats().bytes == bytes.size());
  require_accounted(at_once);
  require(at_once.stats() == in_parts.stats());
  require(whole == chopped);
  at_once.restart();
  require(at_once.pending() == 0);
  require_accounted(at_once);
}

}  // namespace nacelle::diff_drive
