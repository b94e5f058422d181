// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::cli {

/// std::printf() for external text: control characters other than tab and line end are escaped, "\x1b". Use
/// std::printf() for JSON and other output for programs.
[[gnu::format(printf, 1, 2)]] void print_text(const char* format, ...);

/// Flushes stdout. Returns false if the output cannot be written (the pipe's reader has ended, the disk is full);
/// commands that print repeatedly end then. Threads: one.
[[nodiscard]] bool flush_output();

/// Call at the end of the program: flushes stdout and returns the exit code. A closed pipe is no error; any other write
/// error is printed to stderr and turns kDone into kFailed.
[[nodiscard]] int finish_output(int code);

/// Turns a write beyond the limit of file sizes (ulimit -f) into an error (EFBIG), which is reported; the signal would end the
/// process. Call it before there are threads. Programs that are started get the signal back.
void refuse_oversized_files_without_signal();

/// Descriptors 0, 1 and 2 that were closed at the start become /dev/null, so that no socket or device gets their numbers
/// and is written to by a printf.
void open_missing_standard_streams();

/// Makes each line that is printed to stderr one system call, so that lines of several processes on one stream do not mix. The C
/// library writes an unbuffered line in pieces (glibc 2.41: 128 bytes). Must come before the first output. Text without an end of
/// line needs std::fflush.
void write_errors_by_whole_lines();

}  // namespace nacelle::cli
