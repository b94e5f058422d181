// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_play.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "recording_commands/loaded_component.hpp"
#include "recording_commands/play_container.hpp"
#include "recording_commands/play_keys.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

std::vector<std::string> parameters_of(const BagPlayWish& wish) {
  std::vector<std::string> all;
  const auto add = [&](const char* name, const json& value) {
    all.push_back(fmt::format("{}:={}", name, value.dump()));
  };
  add("storage.uri", std::filesystem::absolute(wish.path).lexically_normal().string());
  add("play.rate", wish.rate);
  add("play.loop", wish.loop);
  add("play.start_paused", wish.start_paused);
  add("play.start_offset", wish.start_offset_s);
  add("play.playback_duration", wish.duration_s);
  add("play.clock_publish_frequency", wish.clock_hz);
  if (!wish.topics.empty()) add("play.topics", wish.topics);
  if (!wish.exclude_topics.empty()) add("play.exclude_topics", wish.exclude_topics);
  if (!wish.regex.empty()) add("play.regex", wish.regex);
  if (!wish.exclude_regex.empty()) add("play.exclude_regex", wish.exclude_regex);
  return all;
}

}  // namespace

int play_bag(const BagPlayWish& asked) {
  BagPlayWish wish = asked;
  std::unique_ptr<PlayContainer> own;
  if (wish.whom.container.empty() && std::getenv("NACELLE_CONTAINER") == nullptr && trusted_containers().empty()) {
    auto started = PlayContainer::start();
    if (!started) return complain(started.error());
    own = std::move(*started);
    wish.whom.container = own->name();
  }
  const ask::LoadWish component{
      "nacelle::record::PlayComponent", wish.name, "", parameters_of(wish), wish.remaps, {}, {}};
  DiagnosticRow last;
  std::optional<PlayKeys> keys;
  const int code = run_component(wish.whom, component, wish.name + ": playing", [&](const DiagnosticRow& row) {
    if (last.values.empty()) {
      keys.emplace(wish.whom, wish.name);
      print_text("Playing %s; %sCtrl-C ends it\n", wish.path.c_str(),
                 keys->is_on() ? "space pauses, right plays the next message, up and down change the rate, " : "");
    }
    show_progress(fmt::format("{:.0f} s, {} messages{}", row.seconds("seconds"), row.number("messages"),
                              row.message == "paused" ? ", paused" : ""));
    last = row;
    return row.message != "ended";
  });
  keys.reset();
  if (code != kDone || last.values.empty()) return code;
  print_text("%s messages were published; %s had no reader\n", last.value("messages").c_str(),
             last.value("without a reader").c_str());
  const auto [begin, end] = last.values.equal_range("not played");
  for (auto one = begin; one != end; ++one)
    std::fprintf(stderr, "nacelle: warning: %s was not played; the container's log says why\n", one->second.c_str());
  if (last.number("not decoded") > 0)
    std::fprintf(stderr, "nacelle: warning: %s messages are not of their topic's type\n",
                 last.value("not decoded").c_str());
  return kDone;
}

}  // namespace nacelle::cli
