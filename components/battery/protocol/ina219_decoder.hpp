// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "battery/protocol/ina219_setup.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::battery {

/// What the registers held at one poll.
struct Ina219Reading {
  std::uint16_t config = 0;
  std::int16_t shunt_counts = 0;    ///< 10 uV; positive if the current flows from IN+ to IN-.
  std::uint16_t bus_counts = 0;     ///< 4 mV, between IN- and ground.
  std::int16_t current_counts = 0;  ///< Ina219Setup::amperes_per_count.
  bool is_converted = false;        ///< Both were measured since the configuration was written.
  bool has_overflown = false;       ///< The current does not fit its register: current_counts mean nothing.

  [[nodiscard]] double shunt_v() const { return 1e-5 * shunt_counts; }
  [[nodiscard]] double bus_v() const { return 4e-3 * bus_counts; }
  friend bool operator==(const Ina219Reading&, const Ina219Reading&) = default;
};

/// Readings from the blocks of a polled INA219 (nacelle/io/register_stream.hpp), one block a register, in the order Config, Shunt, Bus, Current.
///
///   offset  bytes  field
///        0      1  tag       Ina219Register
///        1      2  length    2, little-endian
///        3      2  register  big-endian
///
/// Takes any chopping. A byte that begins no such block is skipped; a block out of order begins no reading.
/// Every byte is accounted for: bytes == 5 * blocks + skipped_bytes + pending().
/// Threads: one. Allocates: nothing.
class Ina219Decoder {
 public:
  static constexpr std::size_t kBlockBytes = 5;
  static constexpr std::array kOrder{Ina219Register::Config, Ina219Register::Shunt, Ina219Register::Bus,
                                     Ina219Register::Current};
  struct Stats {
    std::uint64_t bytes{}, blocks{}, readings{}, skipped_bytes{};
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls on_reading(const Ina219Reading&) for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_reading) {
    for (const std::uint8_t byte : bytes) {
      ++stats_.bytes;
      block_[pending_++] = byte;
      if (take()) on_reading(reading_);
    }
  }
  /// What comes next does not continue the last bytes.
  void restart();
  [[nodiscard]] std::size_t pending() const { return pending_; }
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  /// Takes a whole block, or skips what begins none; true if a reading is complete.
  [[nodiscard]] bool take();
  void store(std::uint16_t value);

  std::array<std::uint8_t, kBlockBytes> block_{};
  std::size_t pending_ = 0;
  std::size_t next_ = 0;  // of kOrder
  Ina219Reading reading_;
  Stats stats_;
};

}  // namespace nacelle::battery
