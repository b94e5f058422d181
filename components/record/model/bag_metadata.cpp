// SPDX-License-Identifier: Apache-2.0
#include "record/model/bag_metadata.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string_view>

#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::record {
namespace {

// rmw's infinite time, which is what a duration that is not given means.
constexpr std::int64_t kInfiniteSeconds = 9223372036, kInfiniteNanoseconds = 854775807;

const char* word_of(History value) { return value == History::KeepAll ? "keep_all" : "keep_last"; }
const char* word_of(Reliability value) { return value == Reliability::BestEffort ? "best_effort" : "reliable"; }
const char* word_of(Durability value) { return value == Durability::TransientLocal ? "transient_local" : "volatile"; }
const char* word_of(Liveliness value) { return value == Liveliness::ManualByTopic ? "manual_by_topic" : "automatic"; }

class Lines {
 public:
  template <typename... T>
  void add(int indent, fmt::format_string<T...> format, T&&... values) {
    text_.append(static_cast<std::size_t>(indent), ' ');
    fmt::format_to(std::back_inserter(text_), format, std::forward<T>(values)...);
    text_ += '\n';
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

void add_duration(Lines& lines, int indent, const char* name, Duration value) {
  lines.add(indent, "{}:", name);
  const std::int64_t count = value.count();
  lines.add(indent + 2, "sec: {}", count == 0 ? kInfiniteSeconds : count / 1'000'000'000);
  lines.add(indent + 2, "nsec: {}", count == 0 ? kInfiniteNanoseconds : count % 1'000'000'000);
}

void add_profile(Lines& lines, int indent, const QoS& offered) {
  const QoS qos = offered.resolved();
  lines.add(indent, "- history: {}", word_of(qos.history()));
  lines.add(indent + 2, "depth: {}", qos.depth());
  lines.add(indent + 2, "reliability: {}", word_of(qos.reliability()));
  lines.add(indent + 2, "durability: {}", word_of(qos.durability()));
  add_duration(lines, indent + 2, "deadline", qos.deadline());
  add_duration(lines, indent + 2, "lifespan", qos.lifespan());
  lines.add(indent + 2, "liveliness: {}", word_of(qos.liveliness()));
  add_duration(lines, indent + 2, "liveliness_lease_duration", qos.liveliness_lease_duration());
  lines.add(indent + 2, "avoid_ros_namespace_conventions: {}", qos.avoid_ros_namespace_conventions());
}

/// The shorter one; zero is infinite.
Duration shorter(Duration one, Duration other) {
  if (one == Duration::zero() || other == Duration::zero()) return std::max(one, other);
  return std::min(one, other);
}

/// A text in YAML's double quotes.
std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// 0 for what is no number.
std::uint64_t number_in(const std::string& text) {
  std::uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Zero for what is no duration. One that is too long for the type becomes infinite.
Duration duration_in(const YamlNode* node) {
  if (node == nullptr) return {};
  const auto number = [&](const char* name) {
    const YamlNode* const value = node->find(name);
    return value != nullptr && value->is_scalar() ? number_in(value->text) : 0;
  };
  const std::uint64_t seconds = number("sec"), nanoseconds = number("nsec");
  constexpr auto kMost = static_cast<std::uint64_t>(Duration::max().count());
  constexpr std::uint64_t kSecond = 1'000'000'000;
  if (seconds > kMost / kSecond || nanoseconds > kMost - seconds * kSecond) return Duration::max();
  return Duration{static_cast<Duration::rep>(seconds * kSecond + nanoseconds)};
}

void add_topic(Lines& lines, const BagTopic& topic) {
  lines.add(4, "- topic_metadata:");
  lines.add(8, "name: {}", topic.name);
  lines.add(8, "type: {}", topic.type);
  lines.add(8, "serialization_format: cdr");
  lines.add(8, "offered_qos_profiles:{}", topic.offered.empty() ? " []" : "");
  for (const QoS& qos : topic.offered) add_profile(lines, 10, qos);
  lines.add(8, "type_description_hash: {}", topic.hash);
  lines.add(6, "message_count: {}", topic.messages);
}

}  // namespace

std::string offered_qos_profiles(const std::vector<QoS>& offered) {
  Lines lines;
  for (const QoS& qos : offered) add_profile(lines, 0, qos);
  return offered.empty() ? "[]" : lines.take();
}

std::vector<QoS> read_qos_profiles(const std::string& yaml) {
  const auto document = parse_yaml(yaml, "offered_qos_profiles");
  if (!document || !document->is_sequence()) return {};
  std::vector<QoS> all;
  for (const YamlNode& profile : document->items) {
    const auto text = [&](const char* name) {
      const YamlNode* const value = profile.find(name);
      return value != nullptr && value->is_scalar() ? value->text : std::string{};
    };
    const auto is = [&](const char* name, const char* word, auto number) {
      return text(name) == word || text(name) == std::to_string(static_cast<int>(number));
    };
    // Middlewares do not tell the depth of other nodes, and rosbag2 writes 0 then.
    const auto depth = number_in(text("depth"));
    QoS qos{depth == 0 ? std::size_t{10} : static_cast<std::size_t>(std::min<std::uint64_t>(depth, 1000))};
    if (is("history", "keep_all", History::KeepAll)) qos.keep_all();
    if (is("reliability", "best_effort", Reliability::BestEffort)) qos.best_effort();
    if (is("durability", "transient_local", Durability::TransientLocal)) qos.transient_local();
    if (is("liveliness", "manual_by_topic", Liveliness::ManualByTopic)) qos.liveliness(Liveliness::ManualByTopic);
    qos.deadline(duration_in(profile.find("deadline")));
    qos.lifespan(duration_in(profile.find("lifespan")));
    qos.liveliness_lease_duration(duration_in(profile.find("liveliness_lease_duration")));
    all.push_back(qos);
  }
  return all;
}

QoS strongest_qos(const std::vector<QoS>& offered) {
  if (offered.empty()) return QoS(10);
  QoS qos = offered.front();
  for (const QoS& one : offered) {
    if (one.reliability() == Reliability::Reliable) qos.reliable();
    if (one.durability() == Durability::TransientLocal) qos.transient_local();
    if (one.liveliness() == Liveliness::ManualByTopic) qos.liveliness(Liveliness::ManualByTopic);
    if (!qos.keeps_all() && !one.keeps_all()) qos.keep_last(std::max(qos.depth(), one.depth()));
    qos.deadline(shorter(qos.deadline(), one.deadline()));
    qos.liveliness_lease_duration(shorter(qos.liveliness_lease_duration(), one.liveliness_lease_duration()));
    // Of this one the longest is the strongest.
    const bool is_infinite = qos.lifespan() == Duration::zero() || one.lifespan() == Duration::zero();
    qos.lifespan(is_infinite ? Duration::zero() : std::max(qos.lifespan(), one.lifespan()));
  }
  return qos;
}

std::string metadata_yaml(const BagMetadata& metadata) {
  BagFile whole;
  for (const BagFile& file : metadata.files) {
    if (file.messages == 0) continue;
    whole.first = whole.messages == 0 ? file.first : std::min(whole.first, file.first);
    whole.last = std::max(whole.last, file.last);
    whole.messages += file.messages;
  }
  Lines lines;
  lines.add(0, "rosbag2_bagfile_information:");
  lines.add(2, "version: 9");
  lines.add(2, "storage_identifier: mcap");
  lines.add(2, "duration:");
  lines.add(4, "nanoseconds: {}", whole.last - whole.first);
  lines.add(2, "starting_time:");
  lines.add(4, "nanoseconds_since_epoch: {}", whole.first);
  lines.add(2, "message_count: {}", whole.messages);
  lines.add(2, "topics_with_message_count:{}", metadata.topics.empty() ? " []" : "");
  for (const BagTopic& topic : metadata.topics) add_topic(lines, topic);
  lines.add(2, "compression_format: \"\"");
  lines.add(2, "compression_mode: \"\"");
  lines.add(2, "relative_file_paths:{}", metadata.files.empty() ? " []" : "");
  for (const BagFile& file : metadata.files) lines.add(4, "- {}", in_quotes(file.name));
  lines.add(2, "files:{}", metadata.files.empty() ? " []" : "");
  for (const BagFile& file : metadata.files) {
    lines.add(4, "- path: {}", in_quotes(file.name));
    lines.add(6, "starting_time:");
    lines.add(8, "nanoseconds_since_epoch: {}", file.first);
    lines.add(6, "duration:");
    lines.add(8, "nanoseconds: {}", file.last - file.first);
    lines.add(6, "message_count: {}", file.messages);
  }
  lines.add(2, "custom_data: ~");
  lines.add(2, "ros_distro: jazzy");
  return lines.take();
}

}  // namespace nacelle::record
