// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_record.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/qos/text.hpp"
#include "recording_commands/loaded_component.hpp"
#include "recording_commands/recorder_words.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

/// The recorder replaces %Y and its like; a '%' of the folder that this program runs in stays.
std::string absolute_pattern(const std::string& output) {
  std::string folder = std::filesystem::current_path().string();
  for (std::size_t at = 0; (at = folder.find('%', at)) != std::string::npos; at += 2) folder.insert(at, 1, '%');
  const std::string name = output.empty() ? "rosbag2_%Y_%m_%d-%H_%M_%S" : output;
  std::string path = (std::filesystem::path{folder} / name).lexically_normal().string();
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

constexpr Duration kSnapshotLimit = 120s;  // a slow card

std::int64_t ring_seconds(const std::string& text) {
  const auto length = parse_duration(text);
  return length && *length <= 24h ? *length / 1s : 0;
}

/// 0: it is none.
std::int64_t bytes_in(const std::string& text) {
  constexpr std::int64_t kMost = 1'000'000'000'000;
  std::int64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [after, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{}) return 0;
  const std::string_view unit{after, static_cast<std::size_t>(end - after)};
  for (const auto& [name, factor] :
       {std::pair{"", std::int64_t{1}}, {"kB", 1000}, {"MB", 1000 * 1000}, {"GB", 1000 * 1000 * 1000}}) {
    if (unit == name) return number > 0 && number <= kMost / factor ? number * factor : 0;
  }
  return 0;
}

std::vector<std::string> parameters_of(const BagRecordWish& wish) {
  std::vector<std::string> all;
  // JSON is YAML, in which the container reads values.
  const auto add = [&](const char* name, const json& value) {
    all.push_back(fmt::format("{}:={}", name, value.dump()));
  };
  add("storage.uri", absolute_pattern(wish.output));
  add("storage.compression", wish.compression);
  add("storage.max_bagfile_size", wish.max_size);
  add("storage.max_bagfile_duration", wish.max_duration_s);
  add("record.all_topics", wish.all);
  add("record.include_hidden_topics", wish.hidden);
  add("record.start_paused", wish.start_paused);
  if (!wish.ring.empty()) {
    add("storage.ring", ring_seconds(wish.ring));
    add("storage.ring_size", bytes_in(wish.ring_size));
  }
  if (!wish.topics.empty()) add("record.topics", wish.topics);
  if (!wish.exclude_topics.empty()) add("record.exclude_topics", wish.exclude_topics);
  if (!wish.regex.empty()) add("record.regex", wish.regex);
  if (!wish.exclude_regex.empty()) add("record.exclude_regex", wish.exclude_regex);
  return all;
}

std::string progress_of(const DiagnosticRow& now, const DiagnosticRow& before) {
  const double passed = now.seconds("seconds") - before.seconds("seconds");
  const auto more = static_cast<double>(now.number("bytes") - before.number("bytes"));
  return fmt::format("{:.0f} s, {}, {}/s, {} lost{}", now.seconds("seconds"), size_text(now.number("bytes")),
                     size_text(passed > 0.0 ? static_cast<std::uint64_t>(more / passed) : 0), now.number("lost"),
                     now.message == "paused" ? ", paused" : "");
}

std::string ring_progress_of(const DiagnosticRow& now) {
  return fmt::format("{:.0f} s; the last {:.0f} s are in memory ({}), {} lost{}", now.seconds("seconds"),
                     now.seconds("ring seconds"), size_text(now.number("bytes")), now.number("lost"),
                     now.message == "paused" ? ", paused" : "");
}

void warn_of_losses(const DiagnosticRow& row) {
  for (const auto& [key, value] : row.values) {
    if (key.starts_with("never published")) std::fprintf(stderr, "nacelle: warning: %s\n", key.c_str());
    if (key.starts_with("lost "))
      std::fprintf(stderr, "nacelle: warning: %s: %s messages\n", key.c_str(), value.c_str());
  }
}

/// As record_bag().
int keep_ring(const BagRecordWish& wish, const ask::LoadWish& component) {
  DiagnosticRow last;
  const auto take = [&](const DiagnosticRow& row) {
    if (last.values.empty() && row.level < 2)
      print_text("Keeping the last %s in memory; `nacelle bag snapshot` writes them, Ctrl-C drops them\n",
                 wish.ring.c_str());
    if (row.value("snapshot") != last.value("snapshot"))
      print_text("%s%s is written\n", shows_progress() ? "\r\x1b[K" : "", row.value("snapshot").c_str());
    show_progress(ring_progress_of(row));
    last = row;
    return row.level < 2 && (wish.for_s <= 0.0 || row.seconds("seconds") < wish.for_s);
  };
  const int code = run_component(wish.whom, component, wish.name + ": recording", take);
  if (code != kDone) return code;
  if (last.level == 2) return complain({"recording", last.message, ""});
  print_text("%s snapshot%s of %s\n", last.value("snapshots").c_str(), last.number("snapshots") == 1 ? "" : "s",
             wish.name.c_str());
  warn_of_losses(last);
  return kDone;
}

}  // namespace

int record_bag(const BagRecordWish& wish) {
  if (!wish.all && wish.topics.empty() && wish.regex.empty())
    return complain_of_usage({"bag record", "no topic is chosen", "name topics, or give -a or -e REGEX"});
  for (const auto& topic : wish.topics) {
    if (complain_of_topic_name(topic)) return kUsage;
  }
  const ask::LoadWish component{"nacelle::record::RecordComponent", wish.name, "", parameters_of(wish), {}, {}, {}};
  if (!wish.ring.empty()) return keep_ring(wish, component);
  DiagnosticRow last;
  const auto take = [&](const DiagnosticRow& row) {
    if (last.values.empty()) print_text("Recording into %s; Ctrl-C ends it\n", row.value("folder").c_str());
    show_progress(progress_of(row, last));
    last = row;
    return row.level < 2 && (wish.for_s <= 0.0 || row.seconds("seconds") < wish.for_s);
  };
  const int code = run_component(wish.whom, component, wish.name + ": recording", take);
  if (code != kDone) return code;
  const std::string folder = last.value("folder");
  if (last.level == 2) return complain({"recording", last.message, "what came before is complete"});
  if (folder.empty()) return kDone;  // it ended before the first second was over
  print_text("%s is complete\n", folder.c_str());
  // The last row is up to a second older than the recording's end, which says what was lost of all of it.
  for (const auto& [key, value] : recorder_words(folder)) {
    last.values.erase(key);
    last.values.emplace(key, value);
  }
  warn_of_losses(last);
  return kDone;
}

std::string wrong_ring(const std::string& text) {
  if (ring_seconds(text) >= 1) return {};
  return "'" + text + "' is no time from 1s to 24h; for example 60s";
}

std::string wrong_ring_size(const std::string& text) {
  if (bytes_in(text) >= 1'000'000) return {};
  return "'" + text + "' is no size from 1MB to 1000GB; for example 64MB";
}

int snapshot_bag(const BagSnapshotWish& wish) {
  std::string node;
  bool is_written = false;
  const int asked = ask_nodes(
      wish.whom, false,
      [&](ask::Nodes& nodes) -> Result<json, Problem> {
        const auto found = nodes.find(wish.node);
        if (!found) return err(found.error());
        node = *found;
        return nodes.call(node + "/snapshot", "rosbag2_interfaces/srv/Snapshot", json::object(), kSnapshotLimit);
      },
      [&](const json& response) { is_written = response.value("success", false); });
  if (asked != kDone) return asked;
  DiagnosticRow row;
  const int heard =
      watch_row(wish.whom, node.substr(node.rfind('/') + 1) + ": recording", [&](const DiagnosticRow& now) {
        row = now;
        return false;
      });
  if (is_written) {
    print_text("%s\n", row.value("snapshot").c_str());
    return heard;
  }
  const std::string why = row.value("snapshot problem");
  if (!why.empty()) return complain({"the snapshot", why, ""});
  return complain({"node " + node, "keeps no ring",
                   "start it with `nacelle bag record --ring 60s`, or with the parameter storage.ring"});
}

}  // namespace nacelle::cli
