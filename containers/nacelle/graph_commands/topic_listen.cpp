// SPDX-License-Identifier: Apache-2.0
// Commands that read a topic: its messages, and measurements of them.
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <functional>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/topic_listener.hpp"
#include "graph_commands/topic_commands.hpp"
#include "graph_commands/topic_window.hpp"
#include "text/message_csv.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

Listening listening_of(const TopicWish& wish, const char* show) {
  Listening listening;
  listening.whom = wish.whom;
  listening.topics = {{wish.topic, wish.type}};
  listening.show = show;
  listening.field = wish.field;
  listening.longest = wish.full ? 0 : wish.longest;
  return listening;
}

constexpr double kNs = 1e-9;

/// Reads "<time> <figure>" (the figure may be missing) of each item and shows something once a second.
int measure(
    const TopicWish& wish, const char* items, const std::function<void(double, double)>& take,
    const std::function<bool()>& show, const std::function<void()>& began = [] {}) {
  double shown_at_s = 0;
  Listening listening = listening_of(wish, items);
  listening.least = 2;  // a rate is one of the time between two
  listening.began = began;
  return listen(listening, [&](std::size_t, std::string_view text) {
    std::int64_t time_ns = 0, figure = 0;
    const char* const end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, time_ns);
    if (first.ec != std::errc{}) return true;
    if (first.ptr != end) std::from_chars(first.ptr + 1, end, figure);
    const double now_s = static_cast<double>(time_ns) * kNs;
    take(now_s, static_cast<double>(figure));
    if (shown_at_s == 0) shown_at_s = now_s;
    if (now_s - shown_at_s < 1.0 || !show()) return true;
    shown_at_s = now_s;
    return flush_output() && !wish.once;
  });
}

/// "sensor_msgs/msg/LaserScan" or "sensor_msgs/LaserScan"; a topic that is written without its first '/' looks otherwise.
bool is_type_name(const std::string& word) {
  const auto slash = word.rfind('/');
  const bool has_package = slash != std::string::npos && slash != 0 && word.front() != '/';
  return has_package && slash + 1 < word.size() && std::isupper(static_cast<unsigned char>(word[slash + 1])) != 0;
}

/// Nothing if the first word is a type.
std::vector<Listening::Topic> topics_of(const std::vector<std::string>& words) {
  std::vector<Listening::Topic> topics;
  for (const auto& word : words) {
    if (!is_type_name(word)) {
      topics.push_back({word, ""});
    } else if (topics.empty()) {
      return {};
    } else {
      topics.back().type = word;
    }
  }
  return topics;
}

std::string words_of_bytes(double bytes) {
  std::array<char, 32> text{};
  if (bytes < 1e3) {
    std::snprintf(text.data(), text.size(), "%.0f B", bytes);
  } else if (bytes < 1e6) {
    std::snprintf(text.data(), text.size(), "%.2f KB", bytes * 1e-3);
  } else {
    std::snprintf(text.data(), text.size(), "%.2f MB", bytes * 1e-6);
  }
  return text.data();
}

}  // namespace

int echo_topic(const TopicWish& wish) {
  const char* const values = wish.as_json || wish.as_csv ? "json" : "yaml";
  const Listening listening = listening_of(wish, wish.is_raw ? "raw" : values);
  return listen(listening, [&](std::size_t, std::string_view text) {
    if (wish.as_csv) {
      std::printf("%s\n", text::csv_of_json(text, listening.longest).c_str());
      return flush_output() && !wish.once;
    }
    if (wish.is_raw) {
      std::printf(wish.as_json ? "{\"bytes\":\"%.*s\"}\n" : "%.*s\n---\n", static_cast<int>(text.size()), text.data());
      return flush_output() && !wish.once;
    }
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fputs(wish.as_json ? "\n" : "---\n", stdout);
    return flush_output() && !wish.once;
  });
}

int measure_rate(const TopicWish& asked) {
  const auto topics = topics_of(asked.words);
  if (topics.empty()) {
    return complain_of_usage({"topic hz", "'" + asked.words.front() + "' is a type, and no topic stands before it",
                              "write topic hz TOPIC [TYPE]"});
  }
  if (topics.size() > 1) return measure_rates(asked, topics);
  TopicWish wish = asked;
  wish.topic = topics.front().name;
  wish.type = topics.front().type;
  Window gaps{wish.window};
  double last_s = 0;
  const auto take = [&](double now_s, double) {
    if (last_s != 0) gaps.add(now_s, now_s - last_s);
    last_s = now_s;
  };
  return measure(wish, "times", take, [&] {
    if (gaps.size() == 0) return false;
    if (wish.as_json) {
      std::printf("%s\n", json{{"rate_hz", 1.0 / gaps.mean()},
                               {"min_s", gaps.least()},
                               {"max_s", gaps.most()},
                               {"std_dev_s", gaps.deviation()},
                               {"window", gaps.size()}}
                              .dump()
                              .c_str());
    } else {
      std::printf("average rate: %.3f\n\tmin: %.3fs max: %.3fs std dev: %.5fs window: %zu\n", 1.0 / gaps.mean(),
                  gaps.least(), gaps.most(), gaps.deviation(), gaps.size());
    }
    return true;
  });
}

int measure_bandwidth(const TopicWish& wish) {
  Window sizes{wish.window};
  return measure(
      wish, "sizes", [&](double now_s, double bytes) { sizes.add(now_s, bytes); },
      [&] {
        if (sizes.size() < 2 || sizes.span_s() <= 0) return false;
        // The first message began the time that is measured; it did not come in it.
        const double each = static_cast<double>(sizes.size() - 1) / static_cast<double>(sizes.size());
        const double bytes_per_s = sizes.sum() * each / sizes.span_s();
        if (wish.as_json) {
          std::printf("%s\n", json{{"bytes_per_s", bytes_per_s},
                                   {"mean_bytes", sizes.mean()},
                                   {"min_bytes", sizes.least()},
                                   {"max_bytes", sizes.most()},
                                   {"window", sizes.size()}}
                                  .dump()
                                  .c_str());
        } else {
          std::printf("%s/s from %zu messages\n\tMessage size mean: %s min: %s max: %s\n",
                      words_of_bytes(bytes_per_s).c_str(), sizes.size(), words_of_bytes(sizes.mean()).c_str(),
                      words_of_bytes(sizes.least()).c_str(), words_of_bytes(sizes.most()).c_str());
        }
        return true;
      },
      [&] {
        if (!wish.as_json) std::printf("Subscribed to [%s]\n", absolute(wish.topic).c_str());
        static_cast<void>(flush_output());
      });
}

int measure_delay(const TopicWish& wish) {
  Window ages_s{wish.window};
  return measure(
      wish, "ages", [&](double now_s, double age_ns) { ages_s.add(now_s, age_ns * kNs); },
      [&] {
        if (wish.as_json) {
          std::printf("%s\n", json{{"delay_s", ages_s.mean()},
                                   {"min_s", ages_s.least()},
                                   {"max_s", ages_s.most()},
                                   {"std_dev_s", ages_s.deviation()},
                                   {"window", ages_s.size()}}
                                  .dump()
                                  .c_str());
        } else {
          std::printf("average delay: %.3f\n\tmin: %.3fs max: %.3fs std dev: %.5fs window: %zu\n", ages_s.mean(),
                      ages_s.least(), ages_s.most(), ages_s.deviation(), ages_s.size());
        }
        return true;
      });
}

}  // namespace nacelle::cli
