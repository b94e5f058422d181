// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/loaded_component.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <thread>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/topic_listener.hpp"
#include "nacelle/base/json_text.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

/// Nothing if the message is of other nodes.
std::optional<DiagnosticRow> row_of(std::string_view text, const std::string& name) {
  const json message = parse_json_or_discard(text);
  if (!message.is_object()) return std::nullopt;
  for (const auto& status : message.value("status", json::array())) {
    if (text_of(status, "name") != name) continue;
    DiagnosticRow row{status.value("level", 0), text_of(status, "message"), {}};
    for (const auto& entry : status.value("values", json::array()))
      row.values.emplace(text_of(entry, "key"), text_of(entry, "value"));
    return row;
  }
  return std::nullopt;
}

/// A container answers before it runs: it has to be asked again until its bring-up is over.
Result<json, Problem> load_when_it_runs(ask::Nodes& nodes, const std::string& container, const ask::LoadWish& wish) {
  constexpr Duration kLimit = 20s, kLook = 20ms;
  const SystemClock clock;
  for (const MonotonicTime until = clock.now() + kLimit;;) {
    auto loaded = ask::load_component(nodes, container, wish);
    const bool is_starting = !loaded && loaded.error().code == ProblemCode::from_text("container.not_running") &&
                             loaded.error().value == "starting";
    if (!is_starting || clock.now() >= until) return loaded;
    std::this_thread::sleep_for(kLook);
  }
}

}  // namespace

std::string DiagnosticRow::value(const std::string& key) const {
  const auto found = values.find(key);
  return found == values.end() ? "" : found->second;
}
std::uint64_t DiagnosticRow::number(const std::string& key) const {
  return std::strtoull(value(key).c_str(), nullptr, 10);
}
double DiagnosticRow::seconds(const std::string& key) const { return std::strtod(value(key).c_str(), nullptr); }

int watch_row(const Whom& whom, const std::string& name, const std::function<bool(const DiagnosticRow&)>& take) {
  const Listening listening{whom, {{"/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"}}, "json"};
  return listen(listening, [&](std::size_t, std::string_view text) {
    const auto row = row_of(text, name);
    return !row || take(*row);
  });
}

int run_component(const Whom& whom, const ask::LoadWish& wish, const std::string& name,
                  const std::function<bool(const DiagnosticRow&)>& take) {
  std::string id;
  const int loaded = ask_nodes(
      whom, false, [&](ask::Nodes& nodes) { return load_when_it_runs(nodes, whom.container, wish); },
      [&](const json& reply) { id = std::to_string(reply["id"].get<int>()); });
  if (loaded != kDone) return loaded;
  const int watched = watch_row(whom, name, [&](const DiagnosticRow& row) { return take(row) && flush_output(); });
  if (shows_progress()) std::printf("\n");
  if (watched != kDone) return watched;
  return ask_nodes(
      whom, false, [&](ask::Nodes& nodes) { return ask::unload_component(nodes, whom.container, id); },
      [](const json&) {});
}

bool shows_progress() { return ::isatty(STDOUT_FILENO) == 1; }

void show_progress(const std::string& line) {
  if (!shows_progress()) return;
  print_text("\r%s", line.c_str());
  std::printf("\x1b[K");
}

}  // namespace nacelle::cli
