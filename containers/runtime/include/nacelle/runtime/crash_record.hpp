// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

namespace nacelle::runtime {

class SignalStack;
class StopWatcher;

/// Watches for the process's end by a crash while it lives (design D7): SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, `exit()` and
/// `quick_exit()`.
///
/// The handler writes every registered stop frame first; then a record to the file and to stderr: signal, thread, component,
/// callback, stream, library, offset and symbol, and the calls that led there. Then the signal takes its course (a core dump, a
/// sanitizer's report), or the process ends with the status of the call (1 for 0). It touches nothing but fixed memory and calls what
/// POSIX allows. A watcher process writes the stop frames once more when the process has ended (stop_watcher.hpp), and is what
/// writes them where no handler runs. The making thread gets an alternate signal stack, and its fault signals are unblocked;
/// guard_threads() does both for every other thread.
/// One per process. Threads: made and destroyed by one; it works for all.
class CrashHandler final {
 public:
  /// `file` is written at the crash, not before; empty: stderr only. `container` is the name that the record shows.
  CrashHandler(const std::string& file, const std::string& container);
  ~CrashHandler();
  CrashHandler(const CrashHandler&) = delete;
  CrashHandler& operator=(const CrashHandler&) = delete;

 private:
  const std::unique_ptr<SignalStack> stack_;
  std::unique_ptr<StopWatcher> watcher_;
};

/// Records that this process is about to end by a call of `call` ("exit") and ends it, if a CrashHandler lives here; else returns.
void record_exit(const char* call, int status) noexcept;

/// Writes every registered stop frame of the process; returns how many went out whole. Async-signal-safe.
unsigned write_all_safe_stops() noexcept;

/// What a record's line says ("component", "callback", ...); empty if the text has no such line. Pure.
[[nodiscard]] std::string crash_record_line(const std::string& record, const std::string& key);

}  // namespace nacelle::runtime
