// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::cli {

/// Prints external text as std::printf() does, with control characters other than tab and line end escaped: "\x1b". For
/// JSON and other output for programs, use std::printf().
[[gnu::format(printf, 1, 2)]] void print_text(const char* format, ...);

/// Flushes stdout. Returns false if the output cannot be written (the reader of the pipe has ended, the disk is full).
/// Commands that print repeatedly end then. Threads: one.
[[nodiscard]] bool flush_output();

/// Flushes stdout and returns the exit code. A closed pipe is no error; any other write error is printed to stderr and
/// turns kDone into kFailed. Call it at the end of the program.
[[nodiscard]] int finish_output(int code);

/// Ignores SIGXFSZ, so that a write beyond the limit of file sizes (ulimit -f) fails with EFBIG and is reported instead
/// of ending the process. Call it before other threads start. Started programs get the default handling of the signal.
void refuse_oversized_files_without_signal();

/// Opens /dev/null for each of descriptors 0, 1 and 2 that is closed. Otherwise a socket or a device could get that
/// number, and a printf would write to it.
void open_missing_standard_streams();

/// Makes each line that is printed to stderr one system call, so that lines of several processes on one stream do not
/// mix. The C library writes an unbuffered line in pieces (glibc 2.41: 128 bytes). Call it before the first output.
/// Text without an end of line needs std::fflush.
void write_errors_by_whole_lines();

}  // namespace nacelle::cli
