// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "nacelle/base/time.hpp"
#include "process/key_mode.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::cli {

/// Prints a text repeatedly: on a terminal it is redrawn in place, elsewhere each copy follows the last one.
/// Threads: one.
class LiveText {
 public:
  LiveText();
  LiveText(const LiveText&) = delete;
  LiveText& operator=(const LiveText&) = delete;
  /// Leaves the last text on the terminal, and the cursor below it.
  ~LiveText();

  [[nodiscard]] bool is_on_terminal() const { return on_terminal_; }
  /// Returns the terminal's width in characters, or 0 (no limit) if the output is not a terminal.
  [[nodiscard]] std::size_t columns() const;
  /// Makes the key q end the program, too. Has no effect unless stdin and stdout are a terminal.
  void end_on_q();
  /// Prints the text. On a terminal it replaces the last text and is cut to the terminal's height and width.
  void show(const std::string& text);
  /// Prints a text below the last one. It is not replaced.
  void add(const std::string& text);
  /// Blocks until the limit, the end, or `descriptor` (-1: none) is readable. Returns false if the user has ended it or
  /// the output cannot be written.
  [[nodiscard]] bool wait(Duration limit, int descriptor = -1);
  [[nodiscard]] bool is_to_end() const { return stop_.is_raised() || is_lost_ || has_typed_q_; }

 private:
  process::StopSignal stop_;
  void read_keys();

  std::optional<process::KeyMode> keys_;
  bool on_terminal_, begun_ = false, is_lost_ = false, has_typed_q_ = false;
};

/// Returns the text cut to `rows` lines of `columns` characters (UTF-8). Each line clears the rest of its row. If lines
/// are left out, the last line reports their number. Pure.
[[nodiscard]] std::string fit_to_terminal(const std::string& text, std::size_t rows, std::size_t columns);

}  // namespace nacelle::cli
