// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "nacelle/base/time.hpp"
#include "process/service_manager.hpp"

namespace nacelle::session {

/// Feeds the service manager's watchdog, as long as the robot makes progress (docs/adr/0037).
///
/// The main thread feeds it: from its loop, and while it waits for a component, which has a limit. So a main thread that makes
/// no progress feeds nothing.
/// Threads: the main thread.
class Watchdog {
 public:
  using Say = std::function<void(const std::string& line)>;
  /// `why_not` returns why the watchdog is not fed now; empty: it is. `manager` and `clock` must outlive this object.
  Watchdog(const process::ServiceManager& manager, std::function<std::string()> why_not, const Clock& clock, Say say);

  /// Begins: the service manager counts from READY=1 on. Does nothing if it has no watchdog.
  void begin();
  /// Returns when work() has to run; nothing: never.
  [[nodiscard]] std::optional<MonotonicTime> next_due() const { return due_; }
  /// Feeds the watchdog if it is due and nothing speaks against it. Reports when the feeding stops, and when it goes on.
  void work();

 private:
  const process::ServiceManager& manager_;
  const std::function<std::string()> why_not_;
  const Clock& clock_;
  const Say say_;
  std::optional<MonotonicTime> due_;
  std::string told_;  // why it is not fed, as reported
};

}  // namespace nacelle::session
