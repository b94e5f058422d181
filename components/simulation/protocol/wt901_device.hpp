// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

/// What a WT901 measured, in its own axes.
struct Wt901Reading {
  std::array<double, 3> acceleration_g{};
  std::array<double, 3> angular_velocity_dps{};
  std::array<double, 3> angles_deg{};  ///< roll, pitch, yaw
  std::array<double, 3> magnetic_field_counts{};
  std::array<double, 4> quaternion{1.0, 0.0, 0.0, 0.0};  ///< w x y z
  double temperature_c = 31.0;
};

/// The frame of one type (0x51, 0x52, 0x53, 0x54 or 0x59), 11 bytes. Values beyond the range are held at its end.
/// Source: WitMotion SDK page; WT901 data sheet.
[[nodiscard]] std::array<std::uint8_t, 11> print_wt901(std::uint8_t type, const Wt901Reading& reading);

/// The settings of a WT901 and the host's commands that change them.
///
/// A write to a register counts only within ten seconds after the unlock command, as on the device.
class Wt901Registers {
 public:
  struct Stats {
    std::uint64_t commands{};       ///< Carried out.
    std::uint64_t locked{};         ///< Refused: the registers were not open.
    std::uint64_t skipped_bytes{};  ///< In no command.
  };

  /// Takes bytes of the host; `now_s` is any time that grows.
  void feed(ByteView bytes, double now_s);

  /// Bit n: the device sends type 0x50 + n.
  [[nodiscard]] std::uint16_t mask() const { return mask_; }
  /// 0 means that it sends nothing by itself.
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  void command(std::uint8_t reg, std::uint16_t value, double now_s);

  // As configured once and saved in a robot: 51 52 53 54 59 at 100 Hz. A new device would send 51 to 54 at 10 Hz.
  std::uint16_t mask_ = 0x021E;
  double rate_hz_ = 100.0;
  double unlocked_until_s_ = -1.0;
  std::array<std::uint8_t, 5> pending_{};
  std::size_t length_ = 0;
  Stats stats_;
};

}  // namespace nacelle::simulation
