// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

namespace nacelle::runtime {

class SignalStack;
class StopWatcher;

/// Handles crashes of the process while this object exists (design D7): SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT,
/// `exit()` and `quick_exit()`.
///
/// The handler writes every registered stop frame first; then a record to the file and to stderr: signal, thread,
/// component, callback, stream, library, offset and symbol, and the call stack. Then the signal takes its usual effect
/// (a core dump, a sanitizer's report), or the process ends with the status of the call (1 for 0). The handler uses
/// only fixed memory and async-signal-safe functions. A watcher process writes the stop frames once more when the
/// process has ended (stop_watcher.hpp), also if no handler ran. The constructing thread gets an alternate signal
/// stack, and its fault signals are unblocked; guard_threads() does both for every other thread. One per process.
/// Threads: constructed and destroyed by one thread; it handles crashes of all threads.
class CrashHandler final {
 public:
  /// `file` is created only at a crash; empty: stderr only. `container` is the name in the record.
  CrashHandler(const std::string& file, const std::string& container);
  ~CrashHandler();
  CrashHandler(const CrashHandler&) = delete;
  CrashHandler& operator=(const CrashHandler&) = delete;

 private:
  const std::unique_ptr<SignalStack> stack_;
  std::unique_ptr<StopWatcher> watcher_;
};

/// Records that this process is about to end by a call of `call` ("exit") and ends it, if a CrashHandler exists; else
/// returns.
void record_exit(const char* call, int status) noexcept;

/// Writes every registered stop frame of the process; returns how many were written completely. Async-signal-safe.
unsigned write_all_safe_stops() noexcept;

/// Returns the value of a record's line ("component", "callback", ...); empty if the text has no such line. Pure.
[[nodiscard]] std::string crash_record_line(const std::string& record, const std::string& key);

}  // namespace nacelle::runtime
