// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/node/host.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// Who broadcasts which transform: every child frame has one owner. Threads: any.
class FrameRegistry {
 public:
  FrameRegistry() : claims_(std::make_shared<Claims>()) {}
  [[nodiscard]] std::unique_ptr<FrameClaim> claim(ClaimedFrame frame);
  /// Ends all claims of a node whose own code cannot do it.
  void withdraw(const std::string& node);
  /// Frames with two owners or two parents. A fallback beside an owner with the same parent is none, unless that is fixed.
  [[nodiscard]] std::vector<Problem> conflicts() const;
  [[nodiscard]] std::vector<ClaimedFrame> list() const;
  /// "claims the frame odom -> base_link", each.
  [[nodiscard]] std::vector<std::string> claims() const;

 private:
  class Claim;
  struct Entry {
    ClaimedFrame frame;
    std::atomic<bool>* owner;
  };
  using List = Guarded<std::vector<Entry>>;
  struct Claims {
    List list;
  };
  static void elect(std::vector<Entry>& entries, const std::string& child);
  std::shared_ptr<Claims> claims_;
};

}  // namespace nacelle::runtime
