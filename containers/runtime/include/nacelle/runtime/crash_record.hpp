// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::runtime {

/// Watches for SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT while it lives (design D7).
///
/// The handler writes every registered stop frame first, so that the wheels stop whatever comes after; then a record to the file
/// and to stderr: signal, thread, component, callback, stream, library and offset, and the calls that led there. Then the signal
/// takes its course (a core dump, a sanitizer's report). It touches nothing but fixed memory and calls what POSIX allows.
/// One per process. Threads: made and destroyed by one; it works for all.
class CrashHandler final {
 public:
  /// `file` is written at the crash, not before; empty: stderr only. `container` is the name that the record shows.
  CrashHandler(const std::string& file, const std::string& container);
  ~CrashHandler();
  CrashHandler(const CrashHandler&) = delete;
  CrashHandler& operator=(const CrashHandler&) = delete;
};

/// Writes every registered stop frame of the process; returns how many went out whole. Async-signal-safe.
unsigned write_all_safe_stops() noexcept;

/// What a record's line says ("component", "callback", ...); empty if the text has no such line. Pure.
[[nodiscard]] std::string crash_record_line(const std::string& record, const std::string& key);

}  // namespace nacelle::runtime
