// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>

#include "ask/composition.hpp"
#include "cli/whom.hpp"

namespace nacelle::cli {

/// A component's row of /diagnostics.
struct DiagnosticRow {
  int level = 0;  ///< 0: good, 1: a warning, 2: an error.
  std::string message;
  std::multimap<std::string, std::string> values;

  /// Returns the value of a key; empty if there is none.
  [[nodiscard]] std::string value(const std::string& key) const;
  [[nodiscard]] std::uint64_t number(const std::string& key) const;
  [[nodiscard]] double seconds(const std::string& key) const;
};

/// Hands over the row `name` of /diagnostics each time that it is published, until `take` returns false, Ctrl-C or the container's end. Returns
/// the exit code; errors have been printed.
/// Threads: one.
int watch_row(const Whom& whom, const std::string& name, const std::function<bool(const DiagnosticRow&)>& take);

/// Loads a component, hands over its row `name` each time that it is published, until `take` returns false, Ctrl-C or the container's end, and
/// unloads the component. Returns the exit code; errors have been printed.
/// Threads: one.
int run_component(const Whom& whom, const ask::LoadWish& wish, const std::string& name,
                  const std::function<bool(const DiagnosticRow&)>& take);

/// Returns whether stdout is a terminal: then progress is one line, which show_progress() writes anew.
[[nodiscard]] bool shows_progress();
void show_progress(const std::string& line);

}  // namespace nacelle::cli
