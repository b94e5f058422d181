// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "nacelle/base/time.hpp"
#include "process/key_mode.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::cli {

/// A text that is printed repeatedly: redrawn in place on a terminal, otherwise one copy below the other.
/// Threads: one.
class LiveText {
 public:
  LiveText();
  LiveText(const LiveText&) = delete;
  LiveText& operator=(const LiveText&) = delete;
  /// Leaves the last text on the terminal, and the cursor below it.
  ~LiveText();

  [[nodiscard]] bool is_on_terminal() const { return on_terminal_; }
  /// The terminal's width in characters; 0: the text goes elsewhere, and may be as wide as it is.
  [[nodiscard]] std::size_t columns() const;
  /// Ends it when the user presses q, too, if stdin and stdout are a terminal.
  void end_on_q();
  /// Lines beyond the terminal's height and letters beyond its width are left out while it is redrawn.
  void show(const std::string& text);
  /// A text that stays, below the last one.
  void add(const std::string& text);
  /// Returns false when the user ends it or the output cannot be written. `descriptor`: returns early when it is readable; -1: none.
  [[nodiscard]] bool wait(Duration limit, int descriptor = -1);
  [[nodiscard]] bool is_to_end() const { return stop_.is_raised() || is_lost_ || has_typed_q_; }

 private:
  process::StopSignal stop_;
  void read_keys();

  std::optional<process::KeyMode> keys_;
  bool on_terminal_, begun_ = false, is_lost_ = false, has_typed_q_ = false;
};

/// The text cut to so many lines of so many letters (of UTF-8), each line with what clears the rest of it; if it has more lines, the
/// last one says how many. Pure.
[[nodiscard]] std::string fit_to_terminal(const std::string& text, std::size_t rows, std::size_t columns);

}  // namespace nacelle::cli
