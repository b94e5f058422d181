// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/node/container_facts.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// The last faults of each node, kept after the component has recovered or was unloaded. Threads: one at a time.
class FaultHistory {
 public:
  static constexpr std::size_t kPerNode = 16, kNodes = 256;

  /// `facts`: those that count the faults.
  explicit FaultHistory(std::shared_ptr<ContainerFacts> facts) : facts_(std::move(facts)) {}

  void add(FaultEvent event);
  /// Records the end of the newest open fault of that node and code.
  void end(const std::string& node, const std::string& code, Duration lasted);
  /// Returns all recorded faults in the order in which they happened.
  [[nodiscard]] std::vector<FaultEvent> all() const;

 private:
  const std::shared_ptr<ContainerFacts> facts_;
  std::map<std::string, std::deque<FaultEvent>> of_;
};

}  // namespace nacelle::runtime
