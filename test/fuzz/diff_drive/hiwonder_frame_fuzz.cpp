// SPDX-License-Identifier: Apache-2.0
// Any bytes, in any chopping: nothing crashes, every byte is accounted for, and the reports do not depend on the chopping.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "diff_drive/protocol/hiwonder_frame.hpp"

namespace {

using nacelle::diff_drive::HiwonderDecoder;
using nacelle::diff_drive::HiwonderReport;

void require(bool holds) {
  if (!holds) std::abort();
}

void require_accounted(const HiwonderDecoder& decoder) {
  const auto& stats = decoder.stats();
  require(stats.bytes == stats.frame_bytes + stats.lost_bytes + decoder.pending());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  std::vector<HiwonderReport> whole, chopped;
  HiwonderDecoder at_once, in_parts;
  at_once.feed(bytes, [&](const HiwonderReport& report) { whole.push_back(report); });
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 11U);
    in_parts.feed(bytes.subspan(at, part), [&](const HiwonderReport& report) { chopped.push_back(report); });
    require_accounted(in_parts);
    at += part;
  }
  require(at_once.stats().bytes == size);
  require_accounted(at_once);
  require(at_once.stats() == in_parts.stats());
  require(whole == chopped);
  at_once.restart();
  require(at_once.pending() == 0);
  require_accounted(at_once);
  return 0;
}
