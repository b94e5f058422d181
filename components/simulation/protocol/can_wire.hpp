// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

/// A frame on a CAN bus, as a device's controller hands it over.
struct CanMessage {
  std::uint32_t id = 0;
  bool is_long = false;    ///< An identifier of 29 bits.
  bool is_remote = false;  ///< A request, without data.
  Bytes data;
};

/// As SocketCAN's programs see it: 16 bytes. Source: Documentation/networking/can.rst, struct can_frame.
void append(Bytes& bytes, const CanMessage& message);

/// Cuts bytes into frames, in any chopping. What is no frame of a bus is counted and left out.
class CanWire {
 public:
  [[nodiscard]] std::vector<CanMessage> cut(ByteView bytes);
  [[nodiscard]] std::uint64_t bad_frames() const { return bad_frames_; }

 private:
  Bytes buffer_;
  std::uint64_t bad_frames_ = 0;
};

}  // namespace nacelle::simulation
