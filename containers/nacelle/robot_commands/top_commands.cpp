// SPDX-License-Identifier: Apache-2.0
// `streams` and `top`: tables of the running robot, repeated.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "ask/statistics.hpp"
#include "cli/asking.hpp"
#include "cli/live.hpp"
#include "cli/program.hpp"
#include "report/top_tables.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct WatchWish {
  Whom whom;
  bool as_json = false, once = false;
  double interval_s = 1.0;
};

/// What a command shows of two answers of ask::statistics().
struct View {
  json (*between)(const json& before, const json& after);
  std::string (*text)(const json& table, std::size_t width);
};

/// Live on a terminal until Ctrl-C or q, else one table.
int watch(const WatchWish& wish, const View& view) {
  LiveText live;
  live.end_on_q();
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  auto before = ask::statistics(nodes, wish.whom.container);
  if (!before) return complain(before.error());
  while (live.wait(from_seconds(wish.interval_s))) {
    auto after = ask::statistics(nodes, wish.whom.container);
    if (!after) return complain(after.error());
    const json table = view.between(before.value(), after.value());
    if (wish.as_json) {
      live.add(table.dump() + "\n");
    } else {
      live.show(view.text(table, live.columns()));
    }
    if (wish.once || !live.is_on_terminal()) break;
    before = std::move(after);
  }
  return kDone;
}

void add_view(Command& root, const char* name, const char* what, const char* note, View view) {
  auto wish = std::make_shared<WatchWish>();
  Command& command = root.add(name, what);
  command.option("--interval", wish->interval_s, "seconds between two tables")
      .within(0.1, 3600.0)
      .with_default()
      .value("SECONDS");
  command.flag("--once", wish->once, "print one table and exit; the default if stdout is not a terminal");
  add_common_options(command, wish->whom, wish->as_json);
  command.note(note);
  command.runs([wish, view] { return watch(*wish, view); });
}

}  // namespace

void add_top_commands(Command& root) {
  add_view(
      root, "streams", "show every stream: rate, age, drops by cause, late readers",
      "HZ is measured over the interval; the other figures since the start. AGE: of the last message. P99: from\n"
      "publish() to the callback. DROPPED by cause: overwritten (keep_last), full (keep_all), expired (lifespan),\n"
      "inactive (lifecycle), would_block, pool_dry (when_dry), discarded (with their reader).",
      {report::streams_between, report::streams_text});
  add_view(root, "top", "show the cost of each component: CPU, callbacks, queues",
           "CPU: percent of one core, over the interval. BY: threads and processes of a component's own are measured\n"
           "exactly; callbacks on a shared thread are sampled, about one in 128. MEAN: over the interval. MAX: since\n"
           "the start. QUEUED: waiting messages and the capacity of the queues. MEMORY: of an isolated process; the\n"
           "others share the container's.",
           {report::components_between, report::components_text});
}

}  // namespace nacelle::cli
