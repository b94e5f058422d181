// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/io/scripted_bus.hpp"
#include "simulation/protocol/ina219_chip.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::battery {

/// A bus with an emulated INA219 at 0x40, in manual time: each wait lets time go by, for the chip, too.
[[nodiscard]] inline std::unique_ptr<io::ScriptedBus> make_bus(simulation::Ina219Chip& chip, test::ManualClock& clock) {
  auto bus = std::make_unique<io::ScriptedBus>([&](MonotonicTime until) {
    const Duration dt = until - clock.now();
    if (dt <= Duration::zero()) return;
    clock.advance(dt);
    chip.advance(to_seconds(dt));
  });
  bus->attach(0x40, [&chip](ByteView out, ByteSpan in) { return chip.transfer(out, in); });
  return bus;
}

}  // namespace nacelle::battery
