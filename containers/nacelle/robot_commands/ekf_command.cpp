// SPDX-License-Identifier: Apache-2.0
// `ekf`: what the filters of the running robot measure of themselves, repeated.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "ask/filters.hpp"
#include "cli/asking.hpp"
#include "cli/live.hpp"
#include "cli/program.hpp"
#include "report/filter_table.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

struct EkfWish {
  Whom whom;
  std::string filter;
  bool as_json = false, once = false;
  double interval_s = 1.0;
};

/// Live on a terminal until Ctrl-C or q, else one table.
int watch_filters(const EkfWish& wish) {
  LiveText live;
  live.end_on_q();
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  do {
    const auto filters = ask::list_filters(nodes, wish.filter);
    if (!filters) return complain(filters.error());
    if (wish.as_json) {
      live.add(filters.value().dump() + "\n");
    } else {
      live.show(report::filters_text(filters.value(), live.columns()));
    }
  } while (!wish.once && live.is_on_terminal() && live.wait(from_seconds(wish.interval_s)));
  return kDone;
}

}  // namespace

void add_ekf_command(Command& root) {
  auto wish = std::make_shared<EkfWish>();
  Command& command = root.add("ekf", "show what each input of a filter is worth: rate, delay, rejections, noise");
  command.option("filter", wish->filter, "name or id of the filter; all of them if it is left out")
      .names_a(Names::Node);
  command.option("--interval", wish->interval_s, "seconds between two tables")
      .within(0.1, 3600.0)
      .with_default()
      .value("SECONDS");
  command.flag("--once", wish->once, "print one table and exit; the default if stdout is not a terminal");
  add_common_options(command, wish->whom, wish->as_json);
  command.note(
      "NIS: mean of innovation^2 / expected variance over the last 200 measurements; 1 if the filter's uncertainty is\n"
      "right, above 1 if it is too sure. NOISE: the white noise of the measurement, as a multiple of what its "
      "covariance\n"
      "says. OFFSET: mean innovation in standard deviations; a bias, slip or a delay. REJECTED: with the causes.");
  command.runs([wish] { return watch_filters(*wish); });
}

}  // namespace nacelle::cli
