// SPDX-License-Identifier: Apache-2.0
#include "cli/output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <string>

#include "nacelle/base/printable.hpp"
#include "nacelle/base/problem.hpp"

namespace nacelle::cli {
namespace {

int reason = 0;  // errno of the first flush that failed

}  // namespace

void print_text(const char* format, ...) {
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string text(static_cast<std::size_t>(std::max(length, 0)), '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  text = printable(text);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

bool flush_output() {
  if (reason != 0) return false;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return true;
  reason = errno;
  return false;
}

int finish_output(int code) {
  if (flush_output() || reason == EPIPE) return code;
  const Problem problem{"stdout", std::string{"cannot be written: "} + std::strerror(reason),
                        "is there space where the output goes?"};
  std::fprintf(stderr, "nacelle: %s\n", problem.text().c_str());
  return code == 0 ? 1 : code;
}

void refuse_oversized_files_without_signal() { std::signal(SIGXFSZ, SIG_IGN); }

void open_missing_standard_streams() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
    // The lowest free number is given, which is this one.
    if (::fcntl(fd, F_GETFD) < 0) static_cast<void>(::open("/dev/null", O_RDWR));
  }
}

void write_errors_by_whole_lines() {
  static std::array<char, 16384> buffer;
  static_cast<void>(std::setvbuf(stderr, buffer.data(), _IOLBF, buffer.size()));
}

}  // namespace nacelle::cli
