// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/host/node_host.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// The claims of nodes to broadcast transforms: every child frame has one owner. Threads: any.
class FrameRegistry {
 public:
  FrameRegistry() : claims_(std::make_shared<Claims>()) {}
  [[nodiscard]] std::unique_ptr<FrameClaim> claim(ClaimedFrame frame);
  /// Ends all claims of a node whose own code cannot do it.
  void withdraw(const std::string& node);
  /// Returns the frames with two owners or two parents. A fallback beside an owner with the same parent does not count,
  /// unless that owner is fixed.
  [[nodiscard]] std::vector<Problem> conflicts() const;
  [[nodiscard]] std::vector<ClaimedFrame> list() const;
  /// Returns "claims the frame odom -> base_link" for each.
  [[nodiscard]] std::vector<std::string> claims() const;

 private:
  class Claim;
  struct Entry {
    ClaimedFrame frame;
    std::atomic<bool>* owner;
    std::uint64_t number;  ///< In the order of the claims.
  };
  /// By child: a robot description may have thousands of frames, and few claims are for the same one.
  struct Claims {
    struct Rows {
      std::unordered_map<std::string, std::vector<Entry>> by_child;
      std::uint64_t next_number = 0;
    };
    Guarded<Rows> rows;
  };
  static void elect(std::vector<Entry>& entries);
  std::shared_ptr<Claims> claims_;
};

}  // namespace nacelle::runtime
