// SPDX-License-Identifier: Apache-2.0
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "nacelle/transport_local/link.hpp"
#include "support/rig.hpp"
#include "topology/node_recipe.hpp"
#include "topology/run.hpp"

namespace nacelle::bench {
namespace {

constexpr Duration kWarmingUp = 3s;  // ten processes start at once

[[noreturn]] void give_up(const char* what) {
  std::perror(what);
  std::exit(1);
}

/// Shared pages count in parts. Errors: zero.
std::uint64_t proportional_memory() {
  std::ifstream file("/proc/self/smaps_rollup");
  for (std::string word; file >> word;) {
    if (std::uint64_t kilobytes = 0; word == "Pss:" && file >> kilobytes) return kilobytes * 1024;
  }
  return 0;
}

/// What a process says of itself, through a pipe.
struct Share {
  Tally::Look before, after;
  Usage used;
  Memory memory;
  std::uint64_t pss = 0;
};

Share measure(const Tally& tally, MonotonicTime from, Duration measured) {
  const SystemClock clock;
  Share share;
  std::this_thread::sleep_for(from - clock.now());
  share.before = tally.look();
  share.used = Usage::now();
  std::this_thread::sleep_for(measured);
  share.used = Usage::now() - share.used;
  share.after = tally.look();
  share.memory = Memory::now();
  share.pss = proportional_memory();
  return share;
}

void add(Run& run, const Share& share) {
  run.seen.published += share.after.published - share.before.published;
  run.seen.delivered += share.after.delivered - share.before.delivered;
  run.seen.late += share.after.late - share.before.late;
  run.seen.too_late += share.after.too_late - share.before.too_late;
  run.seen.lost += share.after.lost - share.before.lost;
  run.used.mallocs += share.used.mallocs;
  run.used.faults += share.used.faults;
  run.used.switches += share.used.switches;
  run.used.cpu += share.used.cpu;
  run.used.at = share.used.at;
  run.memory.resident += share.memory.resident;
  run.memory.anonymous += share.memory.anonymous;
  run.memory.proportional += share.pss;
}

LinkOptions options_for(const Graph& graph, bool hub) {
  LinkOptions options;
  options.mirror_all = hub;
  options.find_type = [&graph](const std::string& name) -> const msgs::MessageType* {
    for (const auto& node : graph.nodes) {
      for (const auto& source : node.sources) {
        if (const auto& type = stream_type(source.type).type(); name == type.name) return &type;
      }
    }
    return nullptr;
  };
  return options;
}

[[noreturn]] void be_a_node(const Graph& graph, const GraphNode& node, int socket, int results, MonotonicTime from,
                            Duration measured) {
  const SystemClock clock;
  Tally tally;
  NodeRecipe recipe(node, graph.periods(), tally);
  Rig rig;
  Event ended;
  LinkOptions options = options_for(graph, false);
  options.on_end = [&ended](const Problem&) { ended.set(); };
  Link link(rig.container().graph(), clock, socket, std::move(options));
  link.start();
  rig.add(node.name, recipe);
  const Share share = measure(tally, from, measured);
  if (::write(results, &share, sizeof share) != sizeof share) std::_Exit(1);
  // The other processes still measure. They are done when the socket closes.
  ended.wait();
  std::_Exit(0);
}

}  // namespace

std::uint64_t own_proportional_memory() { return proportional_memory(); }

Run run_apart(const Graph& graph, Duration measured) {
  const SystemClock clock;
  const MonotonicTime from = clock.now() + kWarmingUp;
  int results[2];
  if (::pipe(results) != 0) give_up("topology: pipe");
  // All of them before the first thread of this process.
  std::vector<int> sockets;
  std::vector<pid_t> children;
  for (const auto& node : graph.nodes) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) give_up("topology: socketpair");
    const pid_t child = ::fork();
    if (child < 0) give_up("topology: fork");
    if (child == 0) {
      for (const int other : sockets) ::close(other);
      ::close(ends[0]);
      be_a_node(graph, node, ends[1], results[1], from, measured);
    }
    ::close(ends[1]);
    sockets.push_back(ends[0]);
    children.push_back(child);
  }
  Run run;
  {
    Rig hub;
    std::vector<std::unique_ptr<Link>> links;
    for (const int socket : sockets) {
      links.push_back(std::make_unique<Link>(hub.container().graph(), clock, socket, options_for(graph, true)));
      links.back()->start();
    }
    const Tally nothing;
    add(run, measure(nothing, from, measured));
    for (std::size_t i = 0; i < children.size(); ++i) {
      Share share;
      if (::read(results[0], &share, sizeof share) != sizeof share) give_up("topology: a process is missing");
      add(run, share);
    }
    for (const auto& link : links) {
      run.copies += 2 * link->stats().sent;
      run.dropped += link->stats().dropped + link->stats().broken;
    }
  }
  for (const pid_t child : children) ::waitpid(child, nullptr, 0);
  return run;
}

}  // namespace nacelle::bench
