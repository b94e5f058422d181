// SPDX-License-Identifier: Apache-2.0
// Any bytes as the results of a VL53L0X, in any chopping: nothing crashes, every byte is accounted for, the output does not depend on the
// chopping, and every range is within the limits, infinite or NaN. The first bytes are also the sensor's registers of its steps.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "range/protocol/vl53l0x_decoder.hpp"
#include "range/protocol/vl53l0x_timing.hpp"

namespace {

using namespace nacelle::range;

void require(bool holds) {
  if (!holds) std::abort();
}

std::vector<Vl53l0xResult> decode(nacelle::ByteView bytes, bool chopped) {
  Vl53l0xDecoder decoder;
  std::vector<Vl53l0xResult> results;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = chopped ? std::min<std::size_t>(bytes.size() - at, 1 + bytes[at] % 17U) : bytes.size();
    decoder.feed(bytes.subspan(at, part), [&](const Vl53l0xResult& result) { results.push_back(result); });
    at += part;
  }
  decoder.restart();
  const auto& stats = decoder.stats();
  require(stats.bytes == bytes.size() && stats.results == results.size());
  require(stats.bytes == Vl53l0xDecoder::kRecordBytes * stats.results + stats.dropped + decoder.pending());
  return results;
}

void try_steps(nacelle::ByteView bytes) {
  const Vl53l0xSteps steps{.signal_check = bytes[0],
                           .first_laser_period = bytes[1],
                           .first_timeout = nacelle::load_le16(bytes.data() + 2),
                           .second_laser_period = bytes[4]};
  const auto encoded = second_timeout(nacelle::Duration{bytes[5] * 2'000'000}, steps);
  // What is counted from the begin of the first measurement is not shorter than that, but for what the encoding loses.
  if (encoded) require(decode_periods(*encoded) * 128.0 >= decode_periods(steps.first_timeout) * 127.0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  const auto results = decode(bytes, false);
  require(results == decode(bytes, true));
  for (const auto& result : results) {
    const double range_m = range_of(result, 0.03, 2.0);
    require(std::isnan(range_m) || std::isinf(range_m) || (range_m >= 0.03 && range_m <= 2.0));
  }
  if (size >= 6) try_steps(bytes);
  return 0;
}
