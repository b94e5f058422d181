// SPDX-License-Identifier: Apache-2.0
#include "cli/live.hpp"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>

#include "cli/output.hpp"

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

std::size_t LiveText::columns() const {
  if (!on_terminal_) return 0;
  winsize size{};
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

void LiveText::end_on_q() {
  if (!on_terminal_) return;
  keys_.emplace();
  if (!keys_->is_on()) keys_.reset();
}

bool LiveText::wait(Duration limit, int descriptor) {
  if (is_lost_) return false;
  const SystemClock clock;
  const MonotonicTime until = clock.now() + limit;
  do {
    std::array<pollfd, 3> waits{pollfd{stop_.descriptor(), POLLIN, 0}, pollfd{descriptor, POLLIN, 0},
                                pollfd{keys_ ? STDIN_FILENO : -1, POLLIN, 0}};
    const auto milliseconds = std::max<Duration::rep>(0, (until - clock.now() + 999us) / 1ms);
    ::poll(waits.data(), waits.size(), static_cast<int>(milliseconds));
    if (waits[2].revents != 0) {
      read_keys();
      continue;  // another key changes nothing
    }
    break;
  } while (!is_to_end() && clock.now() < until);
  return !is_to_end();
}

void LiveText::read_keys() {
  std::array<char, 64> typed{};
  const ssize_t got = ::read(STDIN_FILENO, typed.data(), typed.size());
  if (got == 0 || (got < 0 && errno != EINTR && errno != EAGAIN)) keys_.reset();  // the terminal was closed
  for (ssize_t i = 0; i < got; ++i) {
    const char key = typed[static_cast<std::size_t>(i)];
    has_typed_q_ = has_typed_q_ || key == 'q' || key == 'Q';
  }
}

std::string fit_to_terminal(const std::string& text, std::size_t rows, std::size_t columns) {
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  // The last row says what is not shown.
  const std::size_t shown = lines > rows && rows > 0 ? rows - 1 : rows;
  std::string out;
  std::size_t row = 0, column = 0;
  for (const char c : text) {
    if (row == shown) break;
    if (c == '\n') {
      out += "\033[K\n";
      column = 0;
      ++row;
      continue;
    }
    if ((static_cast<unsigned char>(c) & 0xC0U) != 0x80U) ++column;  // not in the middle of a letter
    if (column <= columns) out += c;
  }
  if (shown < rows)
    out += ("(" + std::to_string(lines - shown) + " more lines; --once shows all)").substr(0, columns) + "\033[K\n";
  return out;
}

}  // namespace nacelle::cli
