// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "diff_drive/protocol/can_frame.hpp"

namespace nacelle::diff_drive {

inline void require(bool holds) {
  if (!holds) std::abort();
}

template <typename Decoder>
void require_accounted(const Decoder& decoder) {
  const auto& stats = decoder.stats();
  require(stats.bytes == stats.report_bytes + stats.other_bytes + stats.lost_bytes + decoder.pending());
}

/// Any bytes, in any chopping: nothing crashes, every byte is accounted for, and the reports do not depend on the chopping.
template <typename Decoder, typename Report>
void hold_laws(const std::uint8_t* data, std::size_t size) {
  const ByteView bytes{data, size};
  std::vector<std::pair<Report, std::uint64_t>> whole, chopped;
  Decoder at_once, in_parts;
  at_once.feed(bytes, [&](const Report& report, std::uint64_t first) { whole.emplace_back(report, first); });
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 37U);
    in_parts.feed(bytes.subspan(at, part),
                  [&](const Report& report, std::uint64_t first) { chopped.emplace_back(report, first); });
    require_accounted(in_parts);
    at += part;
  }
  require(at_once.stats().bytes == size);
  require_accounted(at_once);
  require(at_once.stats() == in_parts.stats());
  require(whole == chopped);
  require(whole.size() * kCanRecordBytes == at_once.stats().report_bytes);
  at_once.restart();
  require(at_once.pending() == 0);
  require_accounted(at_once);
}

}  // namespace nacelle::diff_drive
