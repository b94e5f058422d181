// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_record.hpp"

#include <fmt/format.h>

#include <unistd.h>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "ask/composition.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/topic_listener.hpp"
#include "nacelle/base/json_text.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

constexpr const char* kComponent = "nacelle::record::RecordComponent";

/// The recorder replaces %Y and its like; a folder's own '%' stays.
std::string absolute_pattern(const std::string& output) {
  std::string folder = std::filesystem::current_path().string();
  for (std::size_t at = 0; (at = folder.find('%', at)) != std::string::npos; at += 2) folder.insert(at, 1, '%');
  const std::string name = output.empty() ? "rosbag2_%Y_%m_%d-%H_%M_%S" : output;
  return (std::filesystem::path{folder} / name).lexically_normal().string();
}

std::vector<std::string> parameters_of(const BagRecordWish& wish) {
  std::vector<std::string> all;
  // JSON is YAML, in which the container reads values.
  const auto add = [&](const char* name, const json& value) {
    all.push_back(fmt::format("{}:={}", name, value.dump()));
  };
  std::string folder = absolute_pattern(wish.output);
  while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
  add("storage.uri", folder);
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

/// The recorder's row of its diagnostics.
struct Progress {
  std::string folder, message;
  double seconds = 0.0;
  std::uint64_t bytes = 0, messages = 0, lost = 0;
  bool has_failed = false;
  std::vector<std::string> losses;  // "lost to disk: /scan: 12"
};

std::uint64_t number_of(const std::string& text) { return std::strtoull(text.c_str(), nullptr, 10); }

/// Returns false if the message is of another node.
bool read_progress(std::string_view text, const std::string& node, Progress& out) {
  const json message = parse_json_or_discard(text);
  if (!message.is_object()) return false;
  for (const auto& status : message.value("status", json::array())) {
    if (text_of(status, "name") != node + ": recording") continue;
    out.message = text_of(status, "message");
    out.has_failed = status.value("level", 0) == 2;
    out.losses.clear();
    for (const auto& entry : status["values"]) {
      const std::string key = text_of(entry, "key"), value = text_of(entry, "value");
      if (key == "folder") out.folder = value;
      if (key == "seconds") out.seconds = std::strtod(value.c_str(), nullptr);
      if (key == "bytes") out.bytes = number_of(value);
      if (key == "messages") out.messages = number_of(value);
      if (key == "lost") out.lost = number_of(value);
      if (key.starts_with("lost ")) out.losses.push_back(key + ": " + value);
    }
    return true;
  }
  return false;
}

/// On a terminal, one line that changes.
class ProgressLine {
 public:
  void show(const Progress& now) {
    if (!is_terminal_) return;
    const double rate = now.seconds > before_.seconds
                            ? static_cast<double>(now.bytes - before_.bytes) / (now.seconds - before_.seconds)
                            : 0.0;
    print_text("\r%.0f s, %s, %s/s, %zu lost%s", now.seconds, size_text(now.bytes).c_str(),
               size_text(static_cast<std::uint64_t>(rate)).c_str(), static_cast<std::size_t>(now.lost),
               now.message == "paused" ? ", paused" : "");
    std::printf("\x1b[K");
    static_cast<void>(flush_output());
    before_ = now;
  }
  ~ProgressLine() {
    if (is_terminal_) std::printf("\n");
  }
  ProgressLine() = default;
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

 private:
  const bool is_terminal_ = ::isatty(STDOUT_FILENO) == 1;
  Progress before_;
};

int watch(const BagRecordWish& wish, Progress& progress) {
  ProgressLine line;
  Listening listening{wish.whom, {{"/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"}}, "json"};
  bool has_begun = false;
  return listen(listening, [&](std::size_t, std::string_view text) {
    if (!read_progress(text, wish.name, progress)) return true;
    if (!has_begun) print_text("Recording into %s; Ctrl-C ends it\n", progress.folder.c_str());
    has_begun = true;
    line.show(progress);
    return flush_output() && !progress.has_failed && (wish.for_s <= 0.0 || progress.seconds < wish.for_s);
  });
}

}  // namespace

int record_bag(const BagRecordWish& wish) {
  if (!wish.all && wish.topics.empty() && wish.regex.empty())
    return complain_of_usage({"bag record", "no topic is chosen", "name topics, or give -a or -e REGEX"});
  for (const auto& topic : wish.topics) {
    if (complain_of_topic_name(topic)) return kUsage;
  }
  std::string id;
  const int loaded = ask_nodes(
      wish.whom, false,
      [&](ask::Nodes& nodes) {
        return ask::load_component(nodes, wish.whom.container,
                                   {kComponent, wish.name, "", parameters_of(wish), {}, {}, {}});
      },
      [&](const json& reply) { id = std::to_string(reply["id"].get<int>()); });
  if (loaded != kDone) return loaded;

  Progress progress;
  const int watched = watch(wish, progress);
  if (watched != kDone) return watched;
  const int unloaded = ask_nodes(
      wish.whom, false, [&](ask::Nodes& nodes) { return ask::unload_component(nodes, wish.whom.container, id); },
      [](const json&) {});
  if (unloaded != kDone) return unloaded;
  if (progress.has_failed)
    return complain({"recording " + progress.folder, progress.message, "what came before is complete"});
  print_text("%s is complete\n", progress.folder.c_str());
  for (const auto& loss : progress.losses) std::fprintf(stderr, "nacelle: warning: %s messages\n", loss.c_str());
  return kDone;
}

}  // namespace nacelle::cli
