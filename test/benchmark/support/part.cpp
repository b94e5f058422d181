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
    auto& recipe = *std::bit_cast<Recipe*>(address);
    built_ = recipe.build(*this);
    on_transition_ = recipe.on_transition();
  }

 private:
  CallbackReturn on_configure(const State&) override { return answer(Transition::Configure); }
  CallbackReturn on_activate(const State&) override { return answer(Transition::Activate); }
  CallbackReturn on_deactivate(const State&) override { return answer(Transition::Deactivate); }
  CallbackReturn on_cleanup(const State&) override { return answer(Transition::Cleanup); }
  CallbackReturn answer(Transition transition) {
    std::string why = on_transition_ ? on_transition_(transition) : "";
    return why.empty() ? CallbackReturn::SUCCESS : refuse(std::move(why));
  }

  std::function<std::string(Transition)> on_transition_;
  std::shared_ptr<void> built_;
};

}  // namespace nacelle::bench

NACELLE_REGISTER_COMPONENT(nacelle::bench::Part)
