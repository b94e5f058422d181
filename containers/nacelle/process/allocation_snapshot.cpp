// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>

#include "process/allocation_counter.hpp"

namespace nacelle::process {
namespace {

auto counter() {
  static const auto take = reinterpret_cast<decltype(&nacelle_take_allocation_snapshot)>(
      ::dlsym(RTLD_DEFAULT, "nacelle_take_allocation_snapshot"));
  return take;
}

}  // namespace

bool allocations_are_counted() { return counter() != nullptr; }

void take_snapshot(AllocationSnapshot& out) {
  out.count = 0;
  out.uncounted = 0;
  if (const auto take = counter()) take(out);
}

}  // namespace nacelle::process
