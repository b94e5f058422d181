// SPDX-License-Identifier: Apache-2.0
// `topic hz` of several topics: one table a second.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/topic_listener.hpp"
#include "graph_commands/topic_commands.hpp"
#include "graph_commands/topic_window.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct Rate {
  std::string topic;
  Window gaps;
  double last_s = 0;
};

json figures_of(const Rate& rate) {
  return {{"topic", rate.topic},       {"rate_hz", 1.0 / rate.gaps.mean()},  {"min_s", rate.gaps.least()},
          {"max_s", rate.gaps.most()}, {"std_dev_s", rate.gaps.deviation()}, {"window", rate.gaps.size()}};
}

using Cells = std::vector<std::string>;

Cells row_of(const Rate& rate) {
  return {rate.topic,
          fmt::format("{:.3f}", 1.0 / rate.gaps.mean()),
          fmt::format("{:.3f}", rate.gaps.least()),
          fmt::format("{:.3f}", rate.gaps.most()),
          fmt::format("{:.5f}", rate.gaps.deviation()),
          std::to_string(rate.gaps.size())};
}

/// As ros2 draws it: headings in the middle of their columns, a line, and the rows to the left.
std::string table_of(const std::vector<Cells>& rows) {
  const Cells headings{"topic", "rate", "min_delta", "max_delta", "std_dev", "window"};
  std::string above, below;
  std::size_t width = 0;
  std::vector<std::size_t> widths;
  for (std::size_t column = 0; column < headings.size(); ++column) {
    std::size_t widest = headings[column].size();
    for (const Cells& row : rows) widest = std::max(widest, row[column].size());
    widths.push_back(widest);
    above += fmt::format("{}{:^{}}", column == 0 ? "" : "   ", headings[column], widest);
    width += widest + (column == 0 ? 0 : 3);
  }
  for (const Cells& row : rows) {
    for (std::size_t column = 0; column < row.size(); ++column)
      below += fmt::format("{}{:<{}}", column == 0 ? "" : "   ", row[column], widths[column]);
    below += "\n";
  }
  return above + "\n" + std::string(width, '=') + "\n" + below;
}

void show(const std::vector<Rate>& rates, bool as_json) {
  json answer = json::array();
  std::vector<Cells> rows;
  for (const Rate& rate : rates) {
    if (rate.gaps.size() == 0) continue;
    answer.push_back(figures_of(rate));
    rows.push_back(row_of(rate));
  }
  if (as_json) {
    std::printf("%s\n", answer.dump().c_str());
  } else {
    std::printf("%s\n", table_of(rows).c_str());
  }
}

}  // namespace

int measure_rates(const TopicWish& wish, const std::vector<Listening::Topic>& topics) {
  std::vector<Rate> rates;
  rates.reserve(topics.size());
  for (const auto& topic : topics) rates.push_back({absolute(topic.name), Window{wish.window}, 0});
  Listening listening;
  listening.whom = wish.whom;
  listening.topics = topics;
  listening.show = "times";
  listening.least = 2;
  listening.began = [&] {
    for (const Rate& rate : rates) {
      if (!wish.as_json) std::printf("Subscribed to [%s]\n", rate.topic.c_str());
    }
    static_cast<void>(flush_output());
  };
  double shown_at_s = 0;
  return listen(listening, [&](std::size_t index, std::string_view text) {
    std::int64_t time_ns = 0;
    if (std::from_chars(text.data(), text.data() + text.size(), time_ns).ec != std::errc{}) return true;
    const double now_s = static_cast<double>(time_ns) * 1e-9;
    Rate& rate = rates[index];
    if (rate.last_s != 0) rate.gaps.add(now_s, now_s - rate.last_s);
    rate.last_s = now_s;
    if (shown_at_s == 0) shown_at_s = now_s;
    const bool all = std::ranges::all_of(rates, [](const Rate& one) { return one.gaps.size() != 0; });
    const bool any = std::ranges::any_of(rates, [](const Rate& one) { return one.gaps.size() != 0; });
    // A table that is to be the only one has every topic in it.
    if (now_s - shown_at_s < 1.0 || !any || (wish.once && !all)) return true;
    shown_at_s = now_s;
    show(rates, wish.as_json);
    return flush_output() && !wish.once;
  });
}

}  // namespace nacelle::cli
