// SPDX-License-Identifier: Apache-2.0
#include "wire/lonely_mirror.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "support/own_network.hpp"

namespace nacelle::bench {

std::unique_ptr<DdsMirror> start_lonely_mirror(nacelle::Graph& graph, const Clock& clock, ServiceGraph* services) {
  static_cast<void>(test::enter_own_network());  // only this thread and those that it starts
  MirrorOptions options;
  options.domain_id = 7;
  options.config = R"(<General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>)";
  auto made = DdsMirror::start(graph, clock, options, services);
  if (!made) std::fprintf(stderr, "%s\n", made.error().text().c_str()), std::exit(1);
  while ((*made)->stats().snapshots == 0 || (*made)->stats().writers == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return std::move(*made);
}

}  // namespace nacelle::bench
