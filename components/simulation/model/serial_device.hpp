// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::simulation {

/// A device at the end of a serial line, by itself, as `nacelle sim device` runs it: bytes in, bytes out; times are arguments.
///
/// Written from the device's side and from public descriptions of its bytes, so that a driver's decoder is another reading of the
/// same description, and the two meet in a test. The same seed, bytes and times give the same bytes.
/// Threads: one. Allocates: yes; it lives in a process of its own.
class SerialDevice {
 public:
  SerialDevice() = default;
  SerialDevice(const SerialDevice&) = delete;
  SerialDevice& operator=(const SerialDevice&) = delete;
  virtual ~SerialDevice() = default;

  /// Gets what the device begins to send at a time.
  using Send = std::function<void(Duration at, ByteView bytes)>;

  /// Speed of its line. Units: baud.
  [[nodiscard]] virtual unsigned baud() const = 0;
  /// Takes what the host wrote. A device without a receive line ignores it.
  virtual void receive(ByteView /*bytes*/, Duration /*now*/) {}
  /// The host set the modem line DTR; a pty has none.
  virtual void set_data_terminal_ready(bool /*ready*/) {}
  /// Lets time pass until `now`.
  virtual void advance(Duration now, const Send& send) = 0;
};

}  // namespace nacelle::simulation
