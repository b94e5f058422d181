// SPDX-License-Identifier: Apache-2.0
#include "output.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "nacelle/base/problem.hpp"

namespace nacelle::cli {
namespace {

int reason = 0;  // errno of the first flush that failed

}  // namespace

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
