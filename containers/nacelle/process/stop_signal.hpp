// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::process {

/// What a signal does to a stdout whose buffer is full because its reader does not read.
enum class FullOutput : std::uint8_t {
  Kept,     ///< A write() blocks until there is room.
  Dropped,  ///< stdout becomes /dev/null, so that a blocked write() returns.
};

/// What SIGHUP asks for.
enum class Hangup : std::uint8_t {
  Stop,    ///< An orderly end: the terminal of the robot is gone.
  Reload,  ///< New parameters: a service manager started the robot, and it has no terminal.
};

/// Turns SIGINT, SIGTERM, SIGQUIT and SIGHUP into an event that can be polled, from construction to destruction. SIGHUP
/// stays ignored if it was ignored before, as under nohup, unless it asks for a reload. SIGPIPE is ignored.
///
/// The first signal requests an orderly end. Signals up to number `kGracefulSignals` change nothing more. The next
/// one runs the `emergency` function in the signal handler and ends the process with 128 + the signal.
/// Threads: one object per process; is_raised() from any thread.
class StopSignal {
 public:
  /// `emergency` must be async-signal-safe; it may be null.
  explicit StopSignal(void (*emergency)() noexcept = nullptr, FullOutput output = FullOutput::Kept,
                      Hangup hangup = Hangup::Stop);
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  ~StopSignal();

  static constexpr int kGracefulSignals = 2;

  /// Returns a descriptor that becomes readable with the first signal and stays readable.
  [[nodiscard]] int descriptor() const;
  /// Returns a descriptor that becomes readable with each SIGHUP that asks for a reload, until take_reload(); -1 if none does.
  [[nodiscard]] int reload_descriptor() const;
  /// Takes the requests so far as one.
  void take_reload() const;
  [[nodiscard]] bool is_raised() const { return number() != 0; }
  /// Returns the first signal's number, -1 for a request, or 0 for none.
  [[nodiscard]] int number() const;
  /// Returns "SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT" or "a request".
  [[nodiscard]] const char* name() const;
  /// Requests an orderly end without a signal; does not count as one. Threads: any; async-signal-safe.
  void raise_by_request() const;
};

}  // namespace nacelle::process
