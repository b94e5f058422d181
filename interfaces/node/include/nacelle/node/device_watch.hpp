// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle {

/// What a driver does when its device is silent or its cable is pulled (ADR 0022).
enum class DeviceLost : std::uint8_t {
  Wait,   ///< An open fault: the node stays active, and tries the device until it is back.
  Fault,  ///< After the driver's own limit the component is faulted, and on_fault is applied.
};

/// Code of the open fault, the same for every driver.
inline constexpr const char* kDeviceLost = "DEVICE_LOST";

/// The parameters that every driver has.
struct DeviceOptions {
  DeviceLost lost = DeviceLost::Wait;
  bool required = false;  ///< A device that is absent at bring-up fails the configuration.
};

/// Declares `device_lost` (wait) and `required_device` (false).
void declare_device_parameters(Node& node);
/// Errors: a Problem that names the parameter, its value and the way out.
[[nodiscard]] Result<DeviceOptions, Problem> read_device_parameters(const Node& node);

/// Returns how long a device that sends with this period may be silent. A driver looks every 0.1 s, so that silence is reported
/// within half a second, or within three periods where these are longer.
[[nodiscard]] constexpr Duration silence_of(Duration period) { return std::max<Duration>(500ms, 3 * period) - 100ms; }

/// Tells whether a driver's device is there: the one place where silence becomes a fault, for every driver.
///
/// Threads:   the driver's own; is_lost() from any. Make and destroy it while that thread does not run.
/// Allocates: only when the device is lost.
class DeviceWatch {
 public:
  struct Settings {
    std::string device{};  ///< As people know it: "/dev/ttyUSB0".
    Duration silence = silence_of(Duration{});
    std::string fault_code{};  ///< Of DeviceLost::Fault ...
    Duration fault_after{};    ///< ... and the silence that it takes.
  };
  DeviceWatch(LifecycleNode& node, const DeviceOptions& options, Settings settings, MonotonicTime now);
  DeviceWatch(const DeviceWatch&) = delete;
  DeviceWatch& operator=(const DeviceWatch&) = delete;
  /// Closes the open fault.
  ~DeviceWatch();

  /// Sets the silence to silence_of(period): for drivers that learn the period from the device. 0: unknown.
  void expect_every(Duration period) { settings_.silence = silence_of(period); }
  /// Something usable came: ends a loss.
  void heard(MonotonicTime now) {
    last_ = now;
    faulted_ = false;
    if (lost_.load(std::memory_order_relaxed)) end_loss();
  }
  /// The line broke, or cannot be opened: a loss at once, whatever the silence. `why` also replaces an earlier one.
  void lose(const std::string& why);
  /// Time goes by: a loss after the silence. `account()` says in words what came so far.
  template <typename Account>
  void look(MonotonicTime now, Account&& account) {
    if (is_overdue(now)) tell_silence(now, account());
  }
  [[nodiscard]] bool is_lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  [[nodiscard]] bool is_overdue(MonotonicTime now) const;
  void tell_silence(MonotonicTime now, const std::string& account);
  void end_loss();

  LifecycleNode& node_;
  const DeviceOptions options_;
  Settings settings_;
  MonotonicTime last_;
  std::string why_;  // of the loss, as last reported
  bool faulted_ = false;
  std::atomic<bool> lost_{false};
};

}  // namespace nacelle
