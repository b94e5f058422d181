// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <optional>
#include <string_view>

#include "nacelle/base/time.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::process {

/// Sends states to the service manager that started this process (systemd, with Type=notify), as sd_notify(3) does.
///
/// Without a service manager it does nothing.
/// Threads: tell() any.
/// Source: sd_notify(3), sd_watchdog_enabled(3).
class ServiceManager {
 public:
  /// No service manager.
  ServiceManager() = default;
  /// Takes NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID from the environment and removes them, so that programs which this
  /// process starts do not speak for it. Call it before there are other threads.
  [[nodiscard]] static ServiceManager take_from_environment();
  ServiceManager(ServiceManager&& other) noexcept;
  ServiceManager& operator=(ServiceManager&&) = delete;
  ~ServiceManager();

  [[nodiscard]] bool is_there() const { return descriptor_ >= 0; }
  /// Returns the time after which a service that has not sent WATCHDOG=1 is ended; nothing: it need not send any.
  [[nodiscard]] std::optional<Duration> watchdog() const { return watchdog_; }
  /// Sends assignments, one a line: "READY=1\nSTATUS=10 components active". Waits at most a second. Allocates: nothing.
  void tell(std::string_view assignments) const;

 private:
  int descriptor_ = -1;  // kept open: it works when no descriptor is left
  sockaddr_un address_{};
  socklen_t length_ = 0;
  std::optional<Duration> watchdog_;
};

/// A terminal's hangup ends a robot; a service manager's asks for new parameters.
[[nodiscard]] inline Hangup hangup_with(const ServiceManager& manager) {
  return manager.is_there() ? Hangup::Reload : Hangup::Stop;
}

}  // namespace nacelle::process
