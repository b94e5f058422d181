// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"

namespace nacelle {

/// A text that says what a run was started with: a launch file, or the parameters of its nodes.
struct RunText {
  std::string name;        ///< "robot.launch.yaml"
  std::string media_type;  ///< "application/yaml"
  std::string text;
};

/// What a component may know of its container beside its streams.
///
/// A process of an isolated component has its own: the name is that of the process's container, other processes' faults are not counted, and
/// there are no texts.
/// Threads: any.
class ContainerFacts {
 public:
  explicit ContainerFacts(std::string n = {}) : name(std::move(n)) {}

  const std::string name;                ///< In full: "/robot".
  std::atomic<std::uint64_t> faults{0};  ///< How many faults and open faults its components have had.

  /// Returns the files of the launch, and the nodes' parameters as they are now; nothing if the program offers no texts.
  [[nodiscard]] std::vector<RunText> run_texts() const {
    auto read = read_texts_.lock();
    return *read ? (*read)() : std::vector<RunText>{};
  }
  /// For the program: run_texts() calls the function, on any thread, one at a time. An empty one waits until none is called.
  void read_texts_by(std::function<std::vector<RunText>()> read) { *read_texts_.lock() = std::move(read); }

 private:
  Guarded<std::function<std::vector<RunText>()>> read_texts_;
};

/// For Node::shared_object(): the facts of a container.
inline constexpr const char* kContainerFactsName = "nacelle.container_facts";
[[nodiscard]] std::shared_ptr<void> make_container_facts();

}  // namespace nacelle
