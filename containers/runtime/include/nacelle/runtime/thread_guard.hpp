// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::runtime {

/// Links the thread guard into the calling program, and returns whether it is active.
///
/// The guard redefines some functions of the C library. A program's definition takes precedence over the C library's,
/// also for calls from other libraries, so it applies to every thread of the process that is made by pthread_create():
///
/// - `pthread_create`: the thread begins with an alternate signal stack and with the fault signals (SIGSEGV, SIGBUS,
///   SIGFPE, SIGILL, SIGABRT) unblocked, so that an overflow of its stack reaches the handler;
/// - `pthread_sigmask`, `sigprocmask`: leave the fault signals unblocked. A fault whose signal is blocked ends the
///   process without its handler, and so does abort() since glibc 2.41;
/// - `exit`, `quick_exit`: call record_exit() before any destructor runs.
///
/// Threads that are made by clone() or inside the C library (timer_create() with SIGEV_THREAD) are not reached; there
/// the watcher process writes the stop frames. Under a sanitizer, which defines the same functions, this returns false
/// and does nothing.
/// Source: docs/adr/0019-a-watcher-process-writes-the-last-stop.md.
bool guard_threads() noexcept;

}  // namespace nacelle::runtime
