// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/runtime/component_info.hpp"

namespace nacelle::runtime {

/// Executes the load and unload requests of a container's services (Container::compose_through()).
///
/// Threads: one call at a time, on the thread of the container's services. No component waits for it.
class CompositionHost {
 public:
  struct Loaded {
    ComponentInfo component;            ///< In the state it has reached.
    std::vector<std::string> warnings;  ///< For the caller; those in `component` are logged already.
  };

  virtual ~CompositionHost() = default;
  /// Returns the namespace for nodes whose own namespace is relative or empty.
  [[nodiscard]] virtual std::string name_space() const = 0;
  /// Loads a component of the launch file by name. Errors: as load(); an unknown name.
  [[nodiscard]] virtual Result<Loaded, Problem> load_planned(const std::string& name) = 0;
  /// Loads a plugin; a lifecycle component is left unconfigured, or activated. Errors: as Container::load(); it does
  /// not become active.
  [[nodiscard]] virtual Result<Loaded, Problem> load(const LoadRequest& request, bool activate) = 0;
  /// Errors: as Container::unload().
  [[nodiscard]] virtual Result<UnloadOutcome, Problem> unload(std::uint64_t id) = 0;
};

}  // namespace nacelle::runtime
