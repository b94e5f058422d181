// SPDX-License-Identifier: Apache-2.0
// What comes on a topic: its messages, and what is measured of them.
#include <poll.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>

#include "asking.hpp"
#include "nacelle/session/stop_signal.hpp"
#include "output.hpp"
#include "program.hpp"
#include "topic_commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

/// Listens to a topic and gives each item to `take` until that answers false, a signal comes or the container ends.
template <typename Take>
int listen(const TopicWish& wish, const char* show, Take&& take) {
  const session::StopSignal stop;
  auto client = connect(wish.container);
  if (!client) return client.error();
  json request{{"verb", "topic.listen"}, {"topic", absolute(wish.topic)}, {"show", show}};
  if (!wish.type.empty()) request["type"] = full_type_name(wish.type, "msg");
  request["longest"] = wish.full ? 0 : 128;
  auto reply = client.value().call(request, kAnswerLimit);
  if (!reply) return complain(reply.error());
  while (!stop.is_raised()) {
    // First what is here already: a latched topic's message may have come in one piece with the reply, and be the last.
    while (true) {
      auto frame = client.value().receive(0ns);
      if (!frame) return stop.is_raised() ? kDone : complain(frame.error());
      if (!frame.value()) break;
      if (frame.value()->kind == control::FrameKind::Item && !take(as_text(frame.value()->payload))) return kDone;
    }
    std::array<pollfd, 2> waits{pollfd{stop.descriptor(), POLLIN, 0}, pollfd{client.value().descriptor(), POLLIN, 0}};
    ::poll(waits.data(), waits.size(), -1);
  }
  return kDone;
}

/// The last so many messages: when each was published, and one figure of it.
class Window {
 public:
  explicit Window(std::size_t longest) : longest_(longest) {}

  void add(double time_s, double value) {
    times_s_.push_back(time_s);
    values_.push_back(value);
    if (times_s_.size() <= longest_) return;
    times_s_.pop_front();
    values_.pop_front();
  }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  [[nodiscard]] double span_s() const { return times_s_.back() - times_s_.front(); }
  [[nodiscard]] double sum() const {
    double sum = 0;
    for (const double value : values_) sum += value;
    return sum;
  }
  [[nodiscard]] double mean() const { return sum() / static_cast<double>(size()); }
  [[nodiscard]] double least() const { return *std::ranges::min_element(values_); }
  [[nodiscard]] double most() const { return *std::ranges::max_element(values_); }
  [[nodiscard]] double deviation() const {
    double squares = 0;
    for (const double value : values_) squares += (value - mean()) * (value - mean());
    return std::sqrt(squares / static_cast<double>(size()));
  }

 private:
  const std::size_t longest_;
  std::deque<double> times_s_, values_;
};

constexpr double kNs = 1e-9;

/// Reads "<time> <figure>" (the figure may be missing) of each item and shows something once a second.
int measure(const TopicWish& wish, const char* items, const std::function<void(double, double)>& take,
            const std::function<bool()>& show) {
  double shown_at_s = 0;
  return listen(wish, items, [&](std::string_view text) {
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
  return listen(wish, wish.as_json ? "json" : "yaml", [&](std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fputs(wish.as_json ? "\n" : "---\n", stdout);
    return flush_output() && !wish.once;
  });
}

int measure_rate(const TopicWish& wish) {
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
  if (!wish.as_json) std::printf("Subscribed to [%s]\n", absolute(wish.topic).c_str());
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
