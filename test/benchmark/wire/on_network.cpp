// SPDX-License-Identifier: Apache-2.0
#include "topology/run.hpp"
#include "wire/lonely_mirror.hpp"

namespace nacelle::bench {

std::shared_ptr<void> go_on_the_network(runtime::Container& container) {
  static const SystemClock clock;
  return start_lonely_mirror(container.graph(), clock, &container.service_graph());
}

}  // namespace nacelle::bench
