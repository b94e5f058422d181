// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>

#include "nacelle/base/bell.hpp"
#include "nacelle/base/time.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::session {

/// Handles a stop signal while the main thread waits for a component, which may never return.
/// Threads: one of its own, which runs both functions.
class Lookout {
 public:
  /// Calls `act` once, when the signal has come and `patience` (asked then) is over without the destructor having begun.
  Lookout(const process::StopSignal& stop, std::function<Duration()> patience, std::function<void()> act);
  ~Lookout();
  Lookout(const Lookout&) = delete;
  Lookout& operator=(const Lookout&) = delete;

 private:
  Bell over_;
  std::thread thread_;
};

}  // namespace nacelle::session
