// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstdint>

#include "nacelle/node/component.hpp"
#include "support/recipe.hpp"

namespace nacelle::bench {

/// A component whose parameter `recipe` is the address of a Recipe in the program that loads it.
class Part final : public LifecycleNode {
 public:
  explicit Part(const NodeOptions& options) : LifecycleNode("part", options) {
    // An address is the one word that Container::load() can carry from the program to here.
    const auto address = static_cast<std::intptr_t>(declare_parameter("recipe", 0));
    built_ = std::bit_cast<Recipe*>(address)->build(*this);
  }

 private:
  std::shared_ptr<void> built_;
};

}  // namespace nacelle::bench

NACELLE_REGISTER_COMPONENT(nacelle::bench::Part)
