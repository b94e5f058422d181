// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/io/scripted_bus.hpp"
#include "simulation/protocol/vl53l0x_chip.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::range {

/// A bus with an emulated VL53L0X at 0x29, in manual time: each wait lets time go by, for the chip, too.
[[nodiscard]] inline std::unique_ptr<io::ScriptedBus> make_bus(simulation::Vl53l0xChip& chip,
                                                               test::ManualClock& clock) {
  auto bus = std::make_unique<io::ScriptedBus>([&](MonotonicTime until) {
    const Duration dt = until - clock.now();
    if (dt <= Duration::zero()) return;
    clock.advance(dt);
    chip.advance(to_seconds(dt));
  });
  bus->attach(0x29, [&chip](ByteView out, ByteSpan in) { return chip.transfer(out, in); });
  return bus;
}

}  // namespace nacelle::range
