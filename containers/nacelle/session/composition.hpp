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

/// A component as it stood: what it was loaded with, its parameters as they were set since, and its state.
struct ComposedComponent {
  launch::ComponentPlan plan;  ///< `target` is the state.
  bool actuator = false;
  friend bool operator==(const ComposedComponent& a, const ComposedComponent& b);
};

/// What a container held (design D7: the composition outlives the process).
struct Composition {
  std::string container;
  std::vector<ComposedComponent> components;  ///< In the order in which they were loaded.
  std::vector<std::string> emergency_stops;   ///< Topics on which a stop is set (emergency_stops.hpp).
  friend bool operator==(const Composition&, const Composition&) = default;
};

/// As the text of a state file (JSON).
[[nodiscard]] std::string to_text(const Composition& composition);
/// Errors: no composition, one of another version, one that was cut off or changed; `where` names the file. Never throws.
[[nodiscard]] Result<Composition, Problem> parse_composition(std::string_view text, const std::string& where);

/// Nothing: there is no such file. Errors: as parse_composition(); it cannot be read, or is longer than 4 MiB.
[[nodiscard]] Result<std::optional<Composition>, Problem> read_composition(const std::string& file);

/// Replaces what a launch file says of the components by what a container held: those of the composition, in its order, with its
/// parameters and states. What moves something comes back inactive, unless its entry says `resume: active`. A component that does
/// not come up does not take the others down. Pure.
[[nodiscard]] launch::Plan resumed(launch::Plan plan, const Composition& composition, const std::string& file);

/// Writes a state file whenever the text is a new one: beside it, then in its place, so that a reader finds the old one or the
/// new one. Threads: one.
class CompositionFile {
 public:
  explicit CompositionFile(std::string path) : path_(std::move(path)) {}
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Result<void, Problem> write(const Composition& composition);
  /// An orderly end: there is nothing to come back to.
  void remove();

 private:
  const std::string path_;
  std::string last_;
};

}  // namespace nacelle::session
