// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <thread>

#include "nacelle/base/bell.hpp"
#include "nacelle/base/time.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::session {

/// Acts on a stop signal while the main thread is blocked in a component, which may never return.
/// Threads: a thread of its own runs both functions.
class Lookout {
 public:
  /// Calls `act` once if the destructor has not begun `patience()` after the signal. `patience` is called when the
  /// signal arrives.
  Lookout(const process::StopSignal& stop, std::function<Duration()> patience, std::function<void()> act);
  ~Lookout();
  Lookout(const Lookout&) = delete;
  Lookout& operator=(const Lookout&) = delete;

 private:
  Bell over_;
  std::thread thread_;
};

}  // namespace nacelle::session
