// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace nacelle {

/// What a component may know of its container beside its streams.
///
/// A process of an isolated component has its own: the name is that of the process's container, and other processes' faults are not counted.
/// Threads: any.
struct ContainerFacts {
  explicit ContainerFacts(std::string n = {}) : name(std::move(n)) {}
  const std::string name;                ///< In full: "/robot".
  std::atomic<std::uint64_t> faults{0};  ///< How many faults and open faults its components have had.
};

/// For Node::shared_object(): the facts of a container.
inline constexpr const char* kContainerFactsName = "nacelle.container_facts";
[[nodiscard]] std::shared_ptr<void> make_container_facts();

}  // namespace nacelle
