// SPDX-License-Identifier: Apache-2.0
// Any bytes as the blocks of an INA219, in any chopping: nothing crashes, every byte is accounted for, the readings do not depend on the
// chopping, and what they mean is finite and within what the chip can measure.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "battery/model/battery_model.hpp"

namespace {

using namespace nacelle::battery;

void require(bool holds) {
  if (!holds) std::abort();
}

void require_accounted(const Ina219Decoder& decoder) {
  const auto& stats = decoder.stats();
  require(stats.bytes == Ina219Decoder::kBlockBytes * stats.blocks + stats.skipped_bytes + decoder.pending());
}

void require_sound(const Ina219Reading& reading) {
  const Ina219Setup setup{.config = reading.config, .calibration = 4096, .amperes_per_count = 1e-4};
  for (const bool is_reversed : {false, true}) {
    const auto battery = battery_reading(reading, setup, {.is_reversed = is_reversed, .empty_v = 9.0, .full_v = 12.6});
    require(std::isfinite(battery.voltage_v) && std::abs(battery.voltage_v) < 33.2);
    require(!battery.current_a || std::abs(*battery.current_a) <= 3.2768);
    require(battery.current_a.has_value() == (battery.status != BatteryStatus::Unknown));
    require(!battery.percentage || (*battery.percentage >= 0.0 && *battery.percentage <= 1.0));
    require(battery.is_present || !battery.percentage);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  std::vector<Ina219Reading> whole, chopped;
  Ina219Decoder at_once, in_parts;
  at_once.feed(bytes, [&](const Ina219Reading& reading) { whole.push_back(reading); });
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 11U);
    in_parts.feed(bytes.subspan(at, part), [&](const Ina219Reading& reading) { chopped.push_back(reading); });
    require_accounted(in_parts);
    at += part;
  }
  require(at_once.stats().bytes == size);
  require_accounted(at_once);
  require(at_once.stats() == in_parts.stats());
  require(whole == chopped);
  for (const auto& reading : whole) require_sound(reading);
  at_once.restart();
  require(at_once.pending() == 0);
  require_accounted(at_once);
  return 0;
}
