// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/dialogue.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "cli/program.hpp"

namespace nacelle::cli {

void Dialogue::say(const std::string& text) const { std::fprintf(stderr, "%s\n", text.c_str()); }

int Dialogue::interrupted() const {
  std::fprintf(stderr, "\nnacelle: interrupted by %s; nothing was written\n", stop_.name());
  return kInterrupted;
}

int Dialogue::failed(const Problem& problem) const { return stop_.is_raised() ? interrupted() : complain(problem); }

Result<std::string, int> Dialogue::ask(const std::string& question) {
  std::fprintf(stderr, "%s ", question.c_str());
  std::fflush(stderr);
  while (true) {
    if (const auto end = typed_.find('\n'); end != std::string::npos) {
      std::string line = typed_.substr(0, end);
      typed_.erase(0, end + 1);
      if (::isatty(STDIN_FILENO) == 0) say("");  // a terminal has shown the user's own end of line
      return line;
    }
    std::array<pollfd, 2> waits{pollfd{STDIN_FILENO, POLLIN, 0}, pollfd{stop_.descriptor(), POLLIN, 0}};
    if (::poll(waits.data(), waits.size(), -1) < 0 && errno != EINTR)
      return err(complain({"stdin", "cannot be read", "run it in a terminal"}));
    if (stop_.is_raised()) return err(interrupted());
    if (waits[0].revents == 0) continue;
    std::array<char, 256> bytes{};
    const auto got = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (got > 0) {
      typed_.append(bytes.data(), static_cast<std::size_t>(got));
    } else if (got == 0 && !typed_.empty()) {
      typed_ += '\n';  // the last line of a file may lack its end
    } else if (got == 0 || (errno != EINTR && errno != EAGAIN)) {
      say("");
      return err(complain({"stdin", "ended before the answer", "run it in a terminal, or pipe the answers to it"}));
    }
  }
}

Result<double, int> Dialogue::ask_for_number(const std::string& question) {
  while (true) {
    const auto line = ask(question);
    if (!line) return err(line.error());
    if (const double number = positive_number_in(*line); number > 0.0) return number;
    say("  '" + *line + "' is no number above zero; write it like 1.97");
  }
}

Result<double, int> Dialogue::ask_for_any_number(const std::string& question) {
  while (true) {
    const auto line = ask(question);
    if (!line) return err(line.error());
    if (const auto number = number_in_answer(*line)) return *number;
    say("  '" + *line + "' is no number; write it like 0.03, or -0.03");
  }
}

int Dialogue::ask_for_enter(const std::string& what_to_do) {
  const auto line = ask(what_to_do + ", then press Enter");
  return line ? kDone : line.error();
}

double positive_number_in(const std::string& text) {
  const auto number = number_in_answer(text);
  return number && *number > 0.0 ? *number : 0.0;
}

std::optional<double> number_in_answer(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return std::nullopt;
  double number = 0.0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + begin, end, number);
  // Behind it a unit, but not the rest of a number such as "1,97".
  const bool is_whole = read.ptr == end || *read.ptr == ' ' || *read.ptr == '\t';
  return read.ec == std::errc{} && is_whole && std::isfinite(number) ? std::optional{number} : std::nullopt;
}

}  // namespace nacelle::cli
