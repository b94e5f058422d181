// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <condition_variable>
#include <functional>
#include <optional>

#include "nacelle/base/mutex.hpp"
#include "nacelle/io/register_bus.hpp"

namespace nacelle::io {

/// A bus whose devices and faults are written down beforehand: the port that tests use.
///
/// Time is the test's: a wait ends at once if it ends before the time that run_until() has allowed, else it waits for more.
/// `wait` is called with the time at which it ended, and usually moves a manual clock and the devices.
/// Threads: as RegisterBus; the test's calls from any thread. Allocates: yes.
class ScriptedBus final : public RegisterBus {
 public:
  /// A device: takes what is written and fills what is read. False: it does not acknowledge.
  using Device = std::function<bool(ByteView out, ByteSpan in)>;
  using Wait = std::function<void(MonotonicTime until)>;

  explicit ScriptedBus(Wait wait = {}) : wait_(std::move(wait)) {}

  [[nodiscard]] Result<void, StreamFault> transfer(std::uint8_t address, ByteView out, ByteSpan in) override;
  [[nodiscard]] bool wait_until(MonotonicTime time) override;
  void interrupt() noexcept override;
  [[nodiscard]] Result<void, StreamFault> reopen() override;

  /// Puts a device on the bus; a null one takes it off.
  void attach(std::uint8_t address, Device device);
  /// Runs a function while no device is in use: to change one under a reading thread.
  void between_transfers(const std::function<void()>& change);
  /// Lets waits end up to this time.
  void allow_until(MonotonicTime time);
  /// Lets waits end up to this time, and blocks until the reader waits for a later one.
  void run_until(MonotonicTime time);
  /// Every transfer fails in this way from now on; std::nullopt makes them succeed again.
  void fail(std::optional<StreamFault> fault);
  /// Only every n-th transfer fails with NoAnswer; 0: none.
  void lose_every(std::uint64_t n);
  [[nodiscard]] std::uint64_t transfers() const;

 private:
  mutable Mutex mutex_;
  std::condition_variable changed_;
  Wait wait_ NACELLE_GUARDED_BY(mutex_);
  std::array<Device, 128> devices_ NACELLE_GUARDED_BY(mutex_);
  MonotonicTime allowed_ NACELLE_GUARDED_BY(mutex_){};
  std::optional<StreamFault> fault_ NACELLE_GUARDED_BY(mutex_);
  std::uint64_t lose_every_ NACELLE_GUARDED_BY(mutex_) = 0;
  std::uint64_t transfers_ NACELLE_GUARDED_BY(mutex_) = 0;
  bool waits_for_more_ NACELLE_GUARDED_BY(mutex_) = false;
  bool interrupted_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::io
