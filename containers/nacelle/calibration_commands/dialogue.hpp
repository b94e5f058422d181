// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::cli {

/// The exit code of a calibration that a signal ended: the shell's of a program that SIGINT ended, as of `nacelle drive`.
inline constexpr int kInterrupted = 130;

/// Talks with the user: says on stderr, reads lines of stdin. A signal ends every wait.
///
/// Errors: exit codes (cli/program.hpp); the error has been printed.
/// Threads: one; one object per process.
class Dialogue {
 public:
  /// Prints a line on stderr.
  void say(const std::string& text) const;
  /// Prints a question and returns the line that follows, without its end. Errors: a signal; the end of the input.
  [[nodiscard]] Result<std::string, int> ask(const std::string& question);
  /// Asks until the answer is a number above zero.
  [[nodiscard]] Result<double, int> ask_for_number(const std::string& question);
  /// Asks until the answer is a number.
  [[nodiscard]] Result<double, int> ask_for_any_number(const std::string& question);
  /// Asks for Enter. Returns kDone, or the exit code of an error.
  [[nodiscard]] int ask_for_enter(const std::string& what_to_do);

  [[nodiscard]] const process::StopSignal& stop() const { return stop_; }
  /// Reports that a signal has ended it. Returns kInterrupted.
  [[nodiscard]] int interrupted() const;
  /// Reports a problem, or that a signal has ended it. Returns the exit code.
  [[nodiscard]] int failed(const Problem& problem) const;

 private:
  process::StopSignal stop_;
  std::string typed_;
};

/// Parses "-0.03" or "-0.03 m". Returns nothing for anything but a finite number.
[[nodiscard]] std::optional<double> number_in_answer(const std::string& text);
/// Parses "1.97" or "1.97 m". Returns 0 for anything but a finite number above zero.
[[nodiscard]] double positive_number_in(const std::string& text);

}  // namespace nacelle::cli
