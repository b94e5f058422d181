// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"

namespace nacelle::session {

/// A saved component: the settings that it was loaded with, its present parameters, and its state.
struct ComposedComponent {
  launch::ComponentPlan plan;  ///< `target` is the state.
  bool actuator = false;
  friend bool operator==(const ComposedComponent& a, const ComposedComponent& b);
};

/// The composition of a container, which outlives the process (design D7).
struct Composition {
  std::string container;
  std::vector<ComposedComponent> components;  ///< In the order in which they were loaded.
  std::vector<std::string> emergency_stops;   ///< Topics on which a stop is set (emergency_stops.hpp).
  friend bool operator==(const Composition&, const Composition&) = default;
};

/// Returns the text of a state file (JSON).
[[nodiscard]] std::string to_text(const Composition& composition);
/// Errors: text that is not a composition, has another version, or is truncated or damaged; `where` names the file.
/// Never throws.
[[nodiscard]] Result<Composition, Problem> parse_composition(std::string_view text, const std::string& where);

/// Returns nothing if the file does not exist. Errors: as parse_composition(); a file that cannot be read or is longer
/// than 4 MiB.
[[nodiscard]] Result<std::optional<Composition>, Problem> read_composition(const std::string& file);

/// Replaces the components of a launch file by those of the composition, in its order, with its parameters and states.
/// Components that move something come back inactive, unless their entry has `resume: active`. If a component fails to
/// come up, the others are not affected. Pure.
[[nodiscard]] launch::Plan resumed(launch::Plan plan, const Composition& composition, const std::string& file);

/// Writes a state file whenever its text changes. Each write replaces the file atomically, so that a reader finds
/// either the old or the new text. Threads: one.
class CompositionFile {
 public:
  explicit CompositionFile(std::string path) : path_(std::move(path)) {}
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Result<void, Problem> write(const Composition& composition);
  /// Removes the file. Call it at an orderly end.
  void remove();

 private:
  const std::string path_;
  std::string last_;
};

}  // namespace nacelle::session
