// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_record.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "recording_commands/loaded_component.hpp"
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

}  // namespace

int record_bag(const BagRecordWish& wish) {
  if (!wish.all && wish.topics.empty() && wish.regex.empty())
    return complain_of_usage({"bag record", "no topic is chosen", "name topics, or give -a or -e REGEX"});
  for (const auto& topic : wish.topics) {
    if (complain_of_topic_name(topic)) return kUsage;
  }
  const ask::LoadWish component{"nacelle::record::RecordComponent", wish.name, "", parameters_of(wish), {}, {}, {}};
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
  for (const auto& [key, value] : last.values) {
    if (key.starts_with("lost "))
      std::fprintf(stderr, "nacelle: warning: %s: %s messages\n", key.c_str(), value.c_str());
  }
  return kDone;
}

}  // namespace nacelle::cli
