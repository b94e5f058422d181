// SPDX-License-Identifier: Apache-2.0
// Any bytes, in any chopping: nothing crashes, every byte is accounted for, and the output is finite and does not
// depend on the chopping.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "diff_drive/protocol/waveshare_feedback.hpp"

namespace {

using nacelle::diff_drive::BaseFeedback;
using nacelle::diff_drive::WaveshareLineDecoder;

void require(bool holds) {
  if (!holds) std::abort();
}

bool is_finite(const BaseFeedback& f) {
  const double values[] = {f.left_mps,
                           f.right_mps,
                           f.left_travel_m.value_or(0.0),
                           f.right_travel_m.value_or(0.0),
                           f.voltage_v.value_or(0.0),
                           f.roll_rad.value_or(0.0),
                           f.pitch_rad.value_or(0.0),
                           f.yaw_rad.value_or(0.0)};
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

void require_accounted(const WaveshareLineDecoder& decoder) {
  const auto& s = decoder.stats();
  require(s.bytes ==
          s.feedback_bytes + s.other_bytes + s.malformed_bytes + s.overlong_bytes + s.blank_bytes + decoder.pending());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  std::vector<BaseFeedback> whole, chopped;

  WaveshareLineDecoder at_once;
  at_once.feed(bytes, [&](const BaseFeedback& feedback) { whole.push_back(feedback); });
  require(at_once.stats().bytes == size);
  require_accounted(at_once);

  WaveshareLineDecoder in_parts;
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 23U);
    in_parts.feed(bytes.subspan(at, part), [&](const BaseFeedback& feedback) { chopped.push_back(feedback); });
    at += part;
  }
  require(in_parts.stats() == at_once.stats());
  require(whole == chopped);
  for (const auto& feedback : whole) require(is_finite(feedback));

  in_parts.restart();
  require(in_parts.pending() == 0);
  require_accounted(in_parts);
  return 0;
}
