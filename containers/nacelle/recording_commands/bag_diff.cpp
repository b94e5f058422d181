// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_diff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/qos/yaml_tree.hpp"
#include "record/model/recording_diff.hpp"
#include "recording_commands/opened_recording.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;
using record::OrderedMessages;
using record::TopicDiff;

// kFailed says that the recordings differ.
constexpr int kEqual = kDone, kDifferent = kFailed, kNotCompared = kUsage;

double seconds_since(std::uint64_t time, std::uint64_t first) { return static_cast<double>(time - first) * 1e-9; }

const char* plural(std::uint64_t count) { return count == 1 ? "" : "s"; }

/// Returns the messages in their order; null after an error, which has been printed.
std::unique_ptr<OrderedMessages> in_order(const OpenedRecording& recording) {
  std::vector<record::ByteSource*> sources;
  for (const auto& source : recording.sources) sources.push_back(source.get());
  auto opened = OrderedMessages::open(sources);
  if (opened) return std::move(*opened);
  complain(problem_of(recording.files[opened.error().file], opened.error().problem));
  return nullptr;
}

bool complain_of_chunks(const OpenedRecording& recording, const OrderedMessages& messages) {
  for (const auto& problem : messages.problems()) complain(problem_of(recording.files[problem.file], problem.problem));
  return !messages.problems().empty();
}

std::optional<record::Tolerances> read_tolerances(const std::string& path) {
  if (path.empty()) return record::Tolerances{};
  const auto text = read_regular_file(path, kMaxYamlBytes);
  if (!text) {
    complain(text.error());
    return std::nullopt;
  }
  auto parsed = record::Tolerances::parse(*text, path);
  if (parsed) return std::move(*parsed);
  complain(parsed.error());
  return std::nullopt;
}

record::RecordingDiff::Topic topic_in(const OpenedRecording& recording, const std::string& name) {
  const auto found = recording.topics.find(name);
  if (found == recording.topics.end()) return {};
  const auto hash = found->second.metadata.find("topic_type_hash");
  return {found->second.type, hash == found->second.metadata.end() ? "" : hash->second, found->second.messages};
}

/// Returns the topics to compare; nothing if a wanted one is in neither recording, which has been printed.
std::optional<std::set<std::string>> topics_of(const BagDiffWish& wish, const OpenedRecording& a,
                                               const OpenedRecording& b) {
  std::set<std::string> all;
  for (const auto* recording : {&a, &b}) {
    for (const auto& [name, topic] : recording->topics) all.insert(name);
  }
  if (wish.topics.empty()) return all;
  std::set<std::string> wanted;
  for (const auto& topic : wish.topics) {
    const std::string name = absolute(topic);
    if (!all.contains(name)) {
      complain({"topic " + name, "neither recording has it", suggestion(name, {all.begin(), all.end()}), {}, name});
      return std::nullopt;
    }
    wanted.insert(name);
  }
  return wanted;
}

void print_topic(const TopicDiff& topic, const OpenedRecording& a, const OpenedRecording& b) {
  std::string line = topic.name;
  if (topic.type_a.empty() || topic.type_b.empty()) {
    const bool only_a = topic.type_b.empty();
    const auto count = only_a ? topic.in_a : topic.in_b;
    line += fmt::format(" [{}]: {} message{} in {}, not in {}", only_a ? topic.type_a : topic.type_b, count,
                        plural(count), only_a ? "A" : "B", only_a ? "B" : "A");
    return print_text("%s\n", line.c_str());
  }
  line += fmt::format(" [{}]: ", topic.type_a == topic.type_b ? topic.type_a : topic.type_a + " and " + topic.type_b);
  line += topic.in_a == topic.in_b
              ? fmt::format("{} message{} in both", topic.in_a, plural(topic.in_a))
              : fmt::format("{} message{} in A, {} in B", topic.in_a, plural(topic.in_a), topic.in_b);
  line += topic.different == 0 ? fmt::format(", {} equal", topic.equal)
                               : fmt::format(", {} equal, {} different", topic.equal, topic.different);
  if (!topic.remark.empty()) line += " (" + topic.remark + ")";
  print_text("%s\n", line.c_str());
  if (topic.first) {
    const auto& first = *topic.first;
    const std::string path = first.value.path.empty() ? "" : first.value.path + ": ";
    print_text("  first in message %zu at %.3f s in A, %.3f s in B: %s%s in A, %s in B\n",
               static_cast<std::size_t>(first.number), seconds_since(first.time_a, a.first),
               seconds_since(first.time_b, b.first), path.c_str(), first.value.a.c_str(), first.value.b.c_str());
  }
  for (const auto& [name, field] : topic.fields) {
    std::string text = fmt::format("  {}: {} value{}", name, field.values, plural(field.values));
    if (field.is_number)
      text += fmt::format(", at most {:.6g} apart ({}{}message {})", field.largest,
                          field.path == name ? "" : field.path, field.path == name ? "" : ", ", field.round);
    print_text("%s\n", text.c_str());
  }
}

json row_of(const TopicDiff& topic) {
  json fields = json::object();
  for (const auto& [name, field] : topic.fields) {
    json row{{"values", field.values}, {"path", field.path}, {"message", field.round}};
    if (field.is_number) row["largest"] = std::isfinite(field.largest) ? json(field.largest) : json("Infinity");
    fields[name] = std::move(row);
  }
  json first = nullptr;
  if (topic.first)
    first = {{"message", topic.first->number},  {"time_a_ns", topic.first->time_a}, {"time_b_ns", topic.first->time_b},
             {"path", topic.first->value.path}, {"value_a", topic.first->value.a},  {"value_b", topic.first->value.b}};
  const auto type = [](const std::string& name) { return name.empty() ? json(nullptr) : json(name); };
  return {{"topic", topic.name},          {"type_a", type(topic.type_a)}, {"type_b", type(topic.type_b)},
          {"messages_a", topic.in_a},     {"messages_b", topic.in_b},     {"equal", topic.equal},
          {"different", topic.different}, {"first", std::move(first)},    {"fields", std::move(fields)},
          {"remark", topic.remark}};
}

int print_all(const BagDiffWish& wish, const std::vector<TopicDiff>& topics, const OpenedRecording& a,
              const OpenedRecording& b) {
  const auto differing =
      static_cast<std::size_t>(std::ranges::count_if(topics, [](const TopicDiff& topic) { return !topic.is_equal(); }));
  if (wish.as_json) {
    json rows = json::array();
    for (const TopicDiff& topic : topics) rows.push_back(row_of(topic));
    const json all{{"equal", differing == 0}, {"topics", std::move(rows)}};
    std::printf("%s\n", all.dump(2, ' ', false, json::error_handler_t::replace).c_str());
  } else {
    for (const TopicDiff& topic : topics) print_topic(topic, a, b);
    if (differing == 0)
      print_text("equal\n");
    else
      print_text("%zu of %zu topic%s differ%s\n", differing, topics.size(), plural(topics.size()),
                 differing == 1 ? "s" : "");
  }
  return differing == 0 ? kEqual : kDifferent;
}

}  // namespace

int diff_bags(const BagDiffWish& wish) {
  const auto tolerances = read_tolerances(wish.tolerance);
  if (!tolerances) return kNotCompared;
  const auto a = open_whole_recording(wish.a);
  if (!a) return kNotCompared;
  const auto b = open_whole_recording(wish.b);
  if (!b) return kNotCompared;
  const auto of_a = in_order(*a), of_b = in_order(*b);
  if (!of_a || !of_b) return kNotCompared;
  const auto topics = topics_of(wish, *a, *b);
  if (!topics) return kNotCompared;

  msgs::TypeLibrary library{message_library_directories()};
  record::RecordingDiff diff{*tolerances, [&](const std::string& type) {
                               const auto found = library.message(type);
                               return found ? *found : nullptr;
                             }};
  for (const auto& name : *topics) {
    if (const auto added = diff.add_topic(name, topic_in(*a, name), topic_in(*b, name)); !added) {
      complain(added.error());
      return kNotCompared;
    }
  }
  for (const auto& [name, rules] : tolerances->rules()) {
    if (name != "*" && !a->topics.contains(name) && !b->topics.contains(name))
      std::fprintf(stderr, "nacelle: warning: %s: neither recording has the topic %s\n", wish.tolerance.c_str(),
                   name.c_str());
  }
  diff.run(*of_a, *of_b);
  const bool unread_a = complain_of_chunks(*a, *of_a), unread_b = complain_of_chunks(*b, *of_b);
  if (unread_a || unread_b) return kNotCompared;
  return print_all(wish, diff.topics(), *a, *b);
}

}  // namespace nacelle::cli
