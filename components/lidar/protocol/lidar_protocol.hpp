// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "lidar/protocol/sweep.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::lidar {

/// What the host does to the line: bytes to send, a modem line to set, or both.
struct LineAction {
  ByteView bytes{};                         ///< Valid until the protocol's next call.
  std::optional<bool> data_terminal_ready;  ///< DTR, where boards wire it to the motor.
};

/// What the device of a family says, and what must be said to it.
///
/// Pure: holds no line and no clock. The owner feeds it what came, and does what next_action() asks for after each feed(), want()
/// and silence. Threads: one. Allocates: in the constructor, and while a device is being identified.
class LidarProtocol {
 public:
  LidarProtocol() = default;
  LidarProtocol(const LidarProtocol&) = delete;
  LidarProtocol& operator=(const LidarProtocol&) = delete;
  virtual ~LidarProtocol() = default;

  /// Takes bytes in any chopping; calls the sink for each measurement packet.
  virtual void feed(ByteView bytes, SweepSink& sink) = 0;
  /// Forgets half a packet: the line was opened again. A commanded device is identified anew.
  virtual void restart() = 0;
  [[nodiscard]] virtual LineStats stats() const = 0;
  /// Bytes that wait for the rest of their packet.
  [[nodiscard]] virtual std::size_t pending() const = 0;
  /// False if the points' rate is known from a data sheet only, and is to be measured.
  [[nodiscard]] virtual bool knows_its_rate() const { return true; }

  // A device that sends as long as it has power, such as an LD06, needs none of the following.

  /// True for a device that measures only when it is commanded to.
  [[nodiscard]] virtual bool is_commanded() const { return false; }
  /// Says whether the device shall measure. False also stops the motor.
  virtual void want(bool /*measuring*/) {}
  /// The next thing to do to the line, or nothing at this time.
  [[nodiscard]] virtual std::optional<LineAction> next_action(MonotonicTime /*now*/) { return std::nullopt; }
  /// The device does what is wanted, as far as it can be known: identified and stopped, or measuring.
  [[nodiscard]] virtual bool is_settled() const { return stats().frames > 0; }
  /// Why the device cannot be used, in words for a person; empty while nothing is known to be wrong.
  [[nodiscard]] virtual const std::string& refusal() const;
  /// Who the device says it is: "RPLIDAR A1, firmware 1.29, ..."; empty if it says nothing.
  [[nodiscard]] virtual const std::string& identity() const;
};

inline const std::string& LidarProtocol::refusal() const {
  static const std::string kNone;
  return kNone;
}
inline const std::string& LidarProtocol::identity() const {
  static const std::string kNone;
  return kNone;
}

}  // namespace nacelle::lidar
