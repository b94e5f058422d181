// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace nacelle::test {

/// Another machine at the end of a cable: a network namespace of its own, joined with this process's own network
/// (own_network.hpp) by a link that is called kCable on both sides. It ends with this object.
class Neighbour {
 public:
  static constexpr const char* kCable = "lan0";

  Neighbour();
  ~Neighbour();
  Neighbour(const Neighbour&) = delete;
  Neighbour& operator=(const Neighbour&) = delete;

  /// False where the kernel does not let us make such links.
  [[nodiscard]] bool is_there() const { return is_there_; }
  /// The command line that runs `words` there; the first is the program's path.
  [[nodiscard]] std::vector<std::string> within(std::vector<std::string> words) const;

 private:
  pid_t holder_ = -1;
  bool is_there_ = false;
};

}  // namespace nacelle::test
