// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle {

/// `for (auto& x : reversed(xs))`: from the last to the first. std::views::reverse, which clang 14 cannot compile with libstdc++ 12.
template <typename Container>
class Reversed {
 public:
  explicit Reversed(Container& container) : container_(container) {}
  [[nodiscard]] auto begin() const { return container_.rbegin(); }
  [[nodiscard]] auto end() const { return container_.rend(); }

 private:
  Container& container_;
};
template <typename Container>
[[nodiscard]] Reversed<Container> reversed(Container& container) {
  return Reversed<Container>(container);
}

}  // namespace nacelle
