// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"

namespace nacelle::imu {

namespace wt901_layout {
// WitMotion WT901 family, frame of the device: 11 bytes, little-endian.
// Source: WitMotion SDK page (wit-motion.gitbook.io), WT901 and HWT905 data sheets.
//
//   offset  bytes  field     on the wire
//        0      1  start     0x55
//        1      1  type      0x50 to 0x5f
//        2      8  values    four int16
//       10      1  checksum  sum of bytes 0 to 9, modulo 256
//
//   type  values
//   0x51  acceleration x y z in 16 g / 32768, temperature in 0.01 deg C
//   0x52  angular velocity x y z in 2000 deg/s / 32768, temperature or voltage
//   0x53  roll pitch yaw in 180 deg / 32768, firmware version
//   0x54  magnetic field x y z in counts, temperature
//   0x59  quaternion w x y z / 32768
//
// Command of the host: ff aa register low high. Registers are locked until ff aa 69 88 b5, then open for ten seconds.
inline constexpr std::size_t kStart = 0, kType = 1, kValues = 2, kChecksum = 10, kFrameBytes = 11, kCommandBytes = 5;
inline constexpr std::uint8_t kStartByte = 0x55;
static_assert(kValues + 4 * sizeof(std::int16_t) == kChecksum && kChecksum + 1 == kFrameBytes);
}  // namespace wt901_layout

/// The types of frames. Other types exist (clock, ports, pressure, GPS); they are frames without a use here.
enum class Wt901Type : std::uint8_t {
  Acceleration = 0x51,
  AngularVelocity = 0x52,
  Angles = 0x53,
  MagneticField = 0x54,
  Quaternion = 0x59
};

/// One frame, in the device's units.
struct Wt901Frame {
  std::uint8_t type{};  ///< 0x50 to 0x5f
  std::array<std::int16_t, 4> values{};
  [[nodiscard]] bool is(Wt901Type kind) const { return type == static_cast<std::uint8_t>(kind); }
  friend bool operator==(const Wt901Frame&, const Wt901Frame&) = default;
};

/// Register 02: which frames the device sends; bit n stands for type 0x50 + n.
using Wt901Mask = std::uint16_t;
[[nodiscard]] constexpr Wt901Mask mask_bit(Wt901Type type) {
  return static_cast<Wt901Mask>(1U << (static_cast<unsigned>(type) - 0x50U));
}

using Wt901Command = std::array<std::uint8_t, wt901_layout::kCommandBytes>;
/// Opens the registers for ten seconds.
[[nodiscard]] constexpr Wt901Command unlock_command() { return {0xFF, 0xAA, 0x69, 0x88, 0xB5}; }
/// Chooses the frames that are sent.
[[nodiscard]] constexpr Wt901Command mask_command(Wt901Mask mask) {
  return {0xFF, 0xAA, 0x02, static_cast<std::uint8_t>(mask & 0xFFU), static_cast<std::uint8_t>(mask >> 8U)};
}
/// Keeps the settings over a power cycle. The flash wears: not at every start.
[[nodiscard]] constexpr Wt901Command save_command() { return {0xFF, 0xAA, 0x00, 0x00, 0x00}; }
/// Sets how often samples are sent; nothing for a rate that the device does not know (see wt901_rates_hz()).
[[nodiscard]] std::optional<Wt901Command> rate_command(double rate_hz);

/// The rates the device knows. Source: register 03, codes 01 to 0b.
inline constexpr std::array<double, 11> kWt901RatesHz{0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 125, 200};

}  // namespace nacelle::imu
