// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_info.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/problem_json.hpp"
#include "record/model/bag_metadata.hpp"
#include "record/model/recording_summary.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;
using record::RecordedTopic;

/// All files of a recording together. A topic is the same in each file by its name and type.
struct Whole {
  std::vector<std::string> files;
  std::uint64_t bytes = 0, messages = 0, first = 0, last = 0, chunks = 0;
  std::string library, compression, storage = "mcap";
  std::map<std::pair<std::string, std::string>, RecordedTopic> topics;
  std::vector<record::RecordingSummary::Attachment> attachments;
  std::vector<Problem> problems;
  std::map<std::string, std::map<std::string, std::string>>
      notes;  // of Nacelle's recorder: metadata "nacelle.recorder", "nacelle.snapshot"

  void add(const std::string& file, std::uint64_t size, const record::RecordingSummary& part) {
    files.push_back(file);
    bytes += size;
    chunks += part.chunks();
    library = part.library();
    compression = part.compression();
    for (const auto& [id, topic] : part.topics()) merge(topics[{topic.name, topic.type}], topic);
    attachments.insert(attachments.end(), part.attachments().begin(), part.attachments().end());
    for (const auto& [name, words] : part.metadata()) {
      if (name.starts_with("nacelle.")) notes[name] = words;
    }
    for (const auto& problem : part.problems()) problems.push_back(problem_of(file, problem));
    if (part.messages() == 0) return;
    first = messages == 0 ? part.first() : std::min(first, part.first());
    last = messages == 0 ? part.last() : std::max(last, part.last());
    messages += part.messages();
  }

 private:
  static void merge(RecordedTopic& into, const RecordedTopic& topic) {
    if (into.messages == 0) {
      into = topic;
      return;
    }
    if (topic.messages == 0) return;
    if (topic.first > into.last && topic.first - into.last > into.longest_gap) {
      into.longest_gap = topic.first - into.last;
      into.gap_at = into.last;
    }
    if (topic.longest_gap > into.longest_gap) {
      into.longest_gap = topic.longest_gap;
      into.gap_at = topic.gap_at;
    }
    into.first = std::min(into.first, topic.first);
    into.last = std::max(into.last, topic.last);
    into.messages += topic.messages;
    into.bytes += topic.bytes;
  }
};

double seconds(std::uint64_t nanoseconds) { return static_cast<double>(nanoseconds) * 1e-9; }

/// "Nov 28 2026 07:12:40.123 (1795845160.123)", in the machine's time zone.
std::string time_text(std::uint64_t nanoseconds) {
  const auto whole = static_cast<std::time_t>(nanoseconds / 1'000'000'000U);
  std::tm parts{};
  if (::localtime_r(&whole, &parts) == nullptr) return fmt::format("{}.{:09}", whole, nanoseconds % 1'000'000'000U);
  char day[64];
  const std::size_t length = std::strftime(day, sizeof day, "%b %e %Y %H:%M:%S", &parts);
  const auto milliseconds = nanoseconds % 1'000'000'000U / 1'000'000U;
  return fmt::format("{}.{:03} ({}.{:03})", std::string_view{day, length}, milliseconds, whole, milliseconds);
}

std::string topic_text(const RecordedTopic& topic) {
  std::string text = fmt::format("Topic: {} | Type: {} | Count: {} | Serialization Format: {}", topic.name, topic.type,
                                 topic.messages, topic.encoding);
  if (topic.rate_hz() > 0.0)
    text += fmt::format(" | Rate: {:.2f} Hz | Longest gap: {:.3f} s", topic.rate_hz(), seconds(topic.longest_gap));
  if (!topic.has_definition) text += " | No definition";
  return text;
}

std::string note_of(const Whole& whole, const char* record, const char* key) {
  const auto words = whole.notes.find(record);
  if (words == whole.notes.end()) return {};
  const auto value = words->second.find(key);
  return value == words->second.end() ? "" : value->second;
}

void print_text_form(const Whole& whole) {
  std::vector<std::string> names;
  for (const auto& file : whole.files) names.push_back(std::filesystem::path{file}.filename().string());
  std::string pad(19, ' ');
  const auto line = [](const char* title, const std::string& text) { print_text("%-18s %s\n", title, text.c_str()); };
  line("Files:", join(names));
  line("Bag size:", size_text(whole.bytes));
  line("Storage id:", whole.storage);
  line("Library:", whole.library);
  line("Compression:", fmt::format("{}, {} chunk{}", whole.compression, whole.chunks, whole.chunks == 1 ? "" : "s"));
  line("Duration:", fmt::format("{:.9f}s", seconds(whole.last - whole.first)));
  if (whole.messages > 0) {
    line("Start:", time_text(whole.first));
    line("End:", time_text(whole.last));
  }
  line("Messages:", std::to_string(whole.messages));
  const auto note = [&](const char* name, const char* record, const char* key) {
    const std::string text = note_of(whole, record, key);
    if (!text.empty()) line(name, text);
  };
  note("Lost:", record::kRecorderRecord, "lost");
  note("Camera copies:", record::kRecorderRecord, "camera copies");
  note("Snapshot:", "nacelle.snapshot", "reason");
  const char* title = "Topic information:";
  for (const auto& [key, topic] : whole.topics) {
    line(title, topic_text(topic));
    title = "";
  }
  title = "Attachments:";
  for (const auto& attachment : whole.attachments) {
    line(title, fmt::format("{} ({}, {})", attachment.name, attachment.media_type, size_text(attachment.bytes)));
    title = "";
  }
}

void print_json_form(const Whole& whole) {
  json topics = json::array(), attachments = json::array(), problems = json::array();
  for (const auto& [key, topic] : whole.topics) {
    topics.push_back({{"name", topic.name},
                      {"type", topic.type},
                      {"serialization_format", topic.encoding},
                      {"has_definition", topic.has_definition},
                      {"messages", topic.messages},
                      {"bytes", topic.bytes},
                      {"rate_hz", topic.rate_hz()},
                      {"longest_gap_s", seconds(topic.longest_gap)},
                      {"gap_at_ns", topic.gap_at},
                      {"metadata", topic.metadata}});
  }
  for (const auto& attachment : whole.attachments)
    attachments.push_back(
        {{"name", attachment.name}, {"media_type", attachment.media_type}, {"bytes", attachment.bytes}});
  for (const auto& problem : whole.problems) problems.push_back(problem);
  const json all{{"files", whole.files},
                 {"bytes", whole.bytes},
                 {"storage_id", whole.storage},
                 {"library", whole.library},
                 {"compression", whole.compression},
                 {"chunks", whole.chunks},
                 {"start_ns", whole.first},
                 {"end_ns", whole.last},
                 {"messages", whole.messages},
                 {"topics", std::move(topics)},
                 {"attachments", std::move(attachments)},
                 {"notes", whole.notes},
                 {"problems", std::move(problems)}};
  std::printf("%s\n", all.dump(2, ' ', false, json::error_handler_t::replace).c_str());
}

}  // namespace

int print_bag_info(const BagInfoWish& wish) {
  const auto files = recording_files(wish.path);
  if (!files) return complain(files.error());
  Whole whole;
  for (const auto& file : *files) {
    auto source = open_recording(file);
    if (!source) return complain(source.error());
    record::RecordingSummary summary;
    (*source)->walk(summary);
    whole.storage = (*source)->storage();
    whole.add(file, (*source)->size(), summary);
    if (!summary.problems().empty() && summary.problems().front().fault == record::McapFault::NoMagic)
      return complain(whole.problems.back());
  }
  if (wish.as_json) {
    print_json_form(whole);
  } else {
    print_text_form(whole);
    for (const auto& problem : whole.problems) complain(problem);
  }
  return whole.problems.empty() ? kDone : kFailed;
}

}  // namespace nacelle::cli
