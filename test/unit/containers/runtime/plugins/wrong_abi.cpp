// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"

extern "C" __attribute__((visibility("default"))) const nacelle::ComponentTable* nacelle_component_table() {
  static constexpr nacelle::ComponentTable kTable{nacelle::kComponentAbi + 41, 0, nullptr};
  return &kTable;
}
