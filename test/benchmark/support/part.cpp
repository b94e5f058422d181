// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "support/recipe.hpp"

namespace nacelle::bench {

/// A component whose parameter `recipe` is the address of a Recipe in the program that loads it.
class Part final : public LifecycleNode {
 public:
  explicit Part(const NodeOptions& options) : LifecycleNode("part", options) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): the one word that a parameter can carry through Container::load()
    auto* const recipe = reinterpret_cast<Recipe*>(static_cast<std::intptr_t>(declare_parameter("recipe", 0)));
    built_ = recipe->build(*this);
  }

 private:
  std::shared_ptr<void> built_;
};

}  // namespace nacelle::bench

NACELLE_REGISTER_COMPONENT(nacelle::bench::Part)
