// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::process {

/// What a signal does to a stdout that has no room, since nothing reads it.
enum class FullOutput : std::uint8_t {
  Kept,     ///< A write() waits until there is room.
  Dropped,  ///< It becomes /dev/null, so that a write() that waits returns.
};

/// SIGINT, SIGTERM, SIGQUIT and SIGHUP (unless it was ignored before, as under nohup) as an event that can be polled, from
/// construction to destruction; SIGPIPE is ignored.
///
/// The first signal asks for an orderly end. From the second on a person is impatient: after `kGracefulSignals` the
/// `emergency` function runs in the signal handler, and the process ends with 128 + the signal.
/// Threads: one object per process; is_raised() from any thread.
class StopSignal {
 public:
  /// `emergency` must be async-signal-safe; it may be null.
  explicit StopSignal(void (*emergency)() noexcept = nullptr, FullOutput output = FullOutput::Kept);
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  ~StopSignal();

  static constexpr int kGracefulSignals = 2;

  /// Readable once a signal has come, and for ever after.
  [[nodiscard]] int descriptor() const;
  [[nodiscard]] bool is_raised() const { return number() != 0; }
  /// The first signal's number; 0 for none.
  [[nodiscard]] int number() const;
  /// "SIGINT", "SIGTERM", "SIGHUP", or "a request".
  [[nodiscard]] const char* name() const;
  /// As if a signal had come. Threads: any; async-signal-safe.
  void raise_by_request() const;
};

}  // namespace nacelle::process
