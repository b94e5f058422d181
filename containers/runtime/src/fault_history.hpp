// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// The last faults of each node, kept after the component has recovered or was unloaded. Threads: one at a time.
class FaultHistory {
 public:
  static constexpr std::size_t kPerNode = 16, kNodes = 256;

  void add(FaultEvent event);
  /// Records the end of the newest open fault of that node and code.
  void end(const std::string& node, const std::string& code, Duration lasted);
  /// Returns all recorded faults in the order in which they happened.
  [[nodiscard]] std::vector<FaultEvent> all() const;

 private:
  std::uint64_t next_ = 1;
  std::map<std::string, std::deque<FaultEvent>> of_;
};

}  // namespace nacelle::runtime
