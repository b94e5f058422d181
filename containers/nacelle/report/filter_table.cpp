// SPDX-License-Identifier: Apache-2.0
#include "report/filter_table.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "report/text_table.hpp"

namespace nacelle::report {
namespace {

using nlohmann::json;

std::string rejected_cell(const json& rejected) {
  std::string cell;
  for (const auto& [cause, count] : rejected.items())
    cell += fmt::format("{}{} {}", cell.empty() ? "" : ", ", count.get<std::uint64_t>(), cause);
  return cell.empty() ? "0" : cell;
}

std::string noise_cell(const json& axis) {
  const double noise = axis["noise"], scale = axis["scale"];
  return scale > 1.0 ? fmt::format("{:.2f} (taken as {:.2f})", noise, scale) : fmt::format("{:.2f}", noise);
}

void add_input(TextTable& table, const json& input) {
  std::vector<std::string> cells{input["name"], fmt::format("{:.1f}", input["rate_hz"].get<double>()),
                                 fmt::format("{:.1f}", 1e3 * input["delay_s"].get<double>()),
                                 fmt::format("{}", input["fused"].get<std::uint64_t>()),
                                 rejected_cell(input["rejected"])};
  const json& axes = input["axes"];
  if (axes.empty()) cells.insert(cells.end(), {"-", "-", "-", "-"});
  bool first = true;
  for (const json& axis : axes) {
    if (!first) cells.assign(5, "");
    first = false;
    cells.insert(cells.end(), {axis["name"], fmt::format("{:.2f}", axis["nis"].get<double>()), noise_cell(axis),
                               fmt::format("{:+.2f}", axis["offset"].get<double>())});
    table.add_row(std::move(cells));
    cells.clear();
  }
  if (first) table.add_row(std::move(cells));
}

}  // namespace

std::string filters_text(const json& filters, std::size_t width) {
  std::string text;
  for (const json& filter : filters["filters"]) {
    TextTable table{{{"INPUT", false, 6},
                     {"HZ", true, 5},
                     {"DELAY MS", true, 2},
                     {"USED", true, 3},
                     {"REJECTED", false, 4},
                     {"AXIS", false, 6},
                     {"NIS", true, 6},
                     {"NOISE", true, 5},
                     {"OFFSET", true, 1}}};
    bool any = false;
    for (const json& input : filter["inputs"]) add_input(table, input);
    for (const json& input : filter["inputs"]) {
      const std::string sentence = input["sentence"];
      if (sentence.empty()) continue;
      table.add_line(sentence);
      any = true;
    }
    const bool initialised = filter["initialised"];
    if (!initialised) {
      table.add_line("waits for its first measurement");
    } else if (!any) {
      table.add_line("every input is as noisy as its covariance says");
    }
    text += (text.empty() ? "" : "\n") + filter["node"].get<std::string>() + "\n" + table.text(width);
  }
  return text;
}

}  // namespace nacelle::report
