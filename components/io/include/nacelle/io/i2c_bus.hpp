// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/io/descriptor.hpp"
#include "nacelle/io/register_bus.hpp"

namespace nacelle::io {

/// Which bus, and the devices on it that the caller will use.
struct I2cSettings {
  std::string path;                   ///< "/dev/i2c-1": the 40-pin header of a Raspberry Pi.
  std::uint8_t address = 0;           ///< Of the device, 0x08 to 0x77.
  Duration transfer_timeout = 100ms;  ///< A clock line that is held longer is BusStuck. The kernel counts in 10 ms.
};

/// An I2C adapter of the kernel, by I2C_RDWR on /dev/i2c-N.
///
/// Several programs may use one bus, each its own chips; the kernel keeps their transfers apart. A chip that a driver of
/// the kernel has is refused.
class I2cBus final : public RegisterBus {
 public:
  /// Errors: a Problem that names the bus and the way out (not there, no right, no I2C transfers, address in use).
  [[nodiscard]] static Result<std::unique_ptr<I2cBus>, Problem> open(const I2cSettings& settings, const Clock& clock,
                                                                     Duration patience = {});
  /// As open(), but an absent bus is no error: is_away() until reopen() finds it. Does not wait.
  [[nodiscard]] static Result<std::unique_ptr<I2cBus>, Problem> open_or_await(const I2cSettings& settings,
                                                                              const Clock& clock);

  [[nodiscard]] Result<void, StreamFault> transfer(std::uint8_t address, ByteView out, ByteSpan in) override;
  [[nodiscard]] bool wait_until(MonotonicTime time) override;
  void interrupt() noexcept override { bell_.ring(); }
  /// Closes the bus before it opens it: an adapter that was unplugged is only then gone for the kernel.
  [[nodiscard]] Result<void, StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override { return away_.load(std::memory_order_acquire); }

 private:
  I2cBus(I2cSettings settings, const Clock& clock, Descriptor bus);

  I2cSettings settings_;
  const Clock& clock_;
  Descriptor bus_;
  std::atomic<bool> away_{false};
  Bell bell_;
};

}  // namespace nacelle::io
