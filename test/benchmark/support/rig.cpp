// SPDX-License-Identifier: Apache-2.0
#include "support/rig.hpp"

#include <bit>
#include <cstdio>
#include <cstdlib>

namespace nacelle::bench {
namespace {

runtime::ContainerOptions options(Duration patience, runtime::NodeInterfaces interfaces) {
  runtime::ContainerOptions made{.name = "bench", .component_path = {NACELLE_BENCH_PLUGINS}};
  made.node_interfaces = interfaces;
  if (patience > Duration{}) {
    made.handover_after = patience;
    made.hang_after = 2 * patience;
  }
  return made;
}

[[noreturn]] void give_up(const std::string& what) {
  std::fprintf(stderr, "benchmark: %s\n", what.c_str());
  std::exit(1);
}

}  // namespace

Rig::Rig(Duration patience, runtime::NodeInterfaces interfaces) : container_(options(patience, interfaces), clock_) {
  // A faulted component is gated: a wait for its messages would never end.
  container_.on_fault([](const runtime::ComponentInfo& info) {
    std::fprintf(stderr, "benchmark: %s: %s: %s\n", info.node.c_str(), info.fault.code.c_str(),
                 info.fault.text.c_str());
    std::_Exit(1);
  });
}

void Rig::add(const std::string& name, Recipe& recipe, const ThreadPolicy& thread) {
  runtime::LoadRequest request;
  request.plugin = "nacelle::bench::Part";
  request.name = name;
  request.parameters["recipe"] = static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&recipe));
  request.thread = thread;
  const auto loaded = container_.load(request);
  if (!loaded) give_up(loaded.error().text());
  for (const auto step : {Transition::Configure, Transition::Activate}) {
    const auto outcome = container_.trigger(loaded.value().id, step);
    if (!outcome.success) give_up(name + ": " + outcome.reason);
  }
}

}  // namespace nacelle::bench
