// SPDX-License-Identifier: Apache-2.0
#include "live.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "output.hpp"

namespace nacelle::cli {

LiveText::LiveText() : on_terminal_(::isatty(STDOUT_FILENO) == 1) {}

LiveText::~LiveText() {
  if (begun_ && on_terminal_) std::fputs("\033[?25h", stdout);
}

void LiveText::show(const std::string& text) {
  if (on_terminal_) {
    winsize size{};
    const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 1 && size.ws_col > 0;
    if (!begun_) std::fputs("\033[?25l\033[2J", stdout);  // no cursor, an empty screen
    std::fputs("\033[H", stdout);
    std::fputs(fit_to_terminal(text, known ? size.ws_row - 1U : 23, known ? size.ws_col : 80).c_str(), stdout);
    std::fputs("\033[J", stdout);  // what a longer text left below
  } else {
    if (begun_) std::fputs("\n", stdout);
    std::fputs(text.c_str(), stdout);
  }
  begun_ = true;
  is_lost_ = !flush_output();
}

void LiveText::add(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  is_lost_ = !flush_output();
}

bool LiveText::wait(Duration limit, int descriptor) const {
  if (is_lost_) return false;
  std::array<pollfd, 2> waits{pollfd{stop_.descriptor(), POLLIN, 0}, pollfd{descriptor, POLLIN, 0}};
  const auto milliseconds = std::max<Duration::rep>(0, (limit + 999us) / 1ms);
  ::poll(waits.data(), waits.size(), static_cast<int>(milliseconds));
  return !is_to_end();
}

std::string fit_to_terminal(const std::string& text, std::size_t rows, std::size_t columns) {
  std::string out;
  std::size_t row = 0, column = 0;
  for (const char c : text) {
    if (c == '\n') {
      out += "\033[K\n";
      column = 0;
      if (++row == rows) break;
      continue;
    }
    if ((static_cast<unsigned char>(c) & 0xC0U) != 0x80U) ++column;  // not in the middle of a letter
    if (column <= columns) out += c;
  }
  return out;
}

}  // namespace nacelle::cli
