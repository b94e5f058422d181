// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// A device that sends by itself over a serial line, and can therefore be recognised by listening.
struct SerialDevice {
  std::string_view name;     ///< "LD06 or LD19 LiDAR"
  unsigned baud;             ///< As it leaves the factory.
  std::string_view plugin;   ///< The component class that drives it; empty: none does.
  std::string_view port;     ///< That class's parameter for the line.
  std::string_view setting;  ///< A further entry of `param` that it needs for this device, as YAML; may be empty.
  /// Returns the length of the frame that begins here: 0 if none does, more than there is if its end has not come.
  std::size_t (*frame_at)(ByteView bytes);
};

/// Returns every device that is recognised.
/// Source: each frame's layout is in facts of its maker, named beside it in line_signature.cpp.
[[nodiscard]] std::span<const SerialDevice> known_serial_devices();

/// Returns the device whose frames these bytes hold: two whole ones, one behind the other. The bytes may begin anywhere in a frame. Null if
/// no device fits. Allocates: nothing.
[[nodiscard]] const SerialDevice* recognise(ByteView bytes);

/// The first bytes that came over a line, for recognise(). Threads: one. Allocates: nothing.
class FirstBytes {
 public:
  void add(ByteView bytes);
  void forget() { count_ = 0; }
  [[nodiscard]] bool is_full() const { return count_ == bytes_.size(); }
  [[nodiscard]] ByteView view() const { return {bytes_.data(), count_}; }

 private:
  std::array<std::uint8_t, 512> bytes_{};
  std::size_t count_ = 0;
};

/// What a driver expects on its line, in words for a person.
struct ExpectedDevice {
  std::string path;            ///< "/dev/ttyUSB0"
  std::string name;            ///< "LD06"
  unsigned usual_baud = 0;     ///< The device's own, as it leaves the factory.
  unsigned baud = 0;           ///< What the line is set to ...
  std::string baud_parameter;  ///< ... by this parameter.
  std::string when_silent;     ///< What to look at first: "is the LiDAR powered and turning?"
  std::string otherwise{};     ///< What to look at if the bytes explain nothing; empty: the baud rate.
};

/// What came over a line.
struct HeardOnLine {
  std::uint64_t bytes{}, frames{}, bad_checksums{};
  FirstBytes first;
};

/// Says why a line has no usable frames: silence, another device, another baud rate, or a disturbed line.
[[nodiscard]] Problem why_no_frames(const ExpectedDevice& expected, const HeardOnLine& heard, Duration waited);

}  // namespace nacelle::io
