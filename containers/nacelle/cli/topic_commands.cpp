// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <deque>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "commands.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/session/stop_signal.hpp"
#include "program.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

constexpr Duration kAnswerLimit = 10s;

struct Wish {
  std::string container, topic, type, message = "{}";
  bool as_json = false, with_types = false, once = false, full = false;
  double rate_hz = 1.0;
  std::size_t window = 1000, times = 0;
};

int list(const Wish& wish) {
  auto client = connect(wish.container);
  if (!client) return client.error();
  auto reply = client.value().call({{"verb", "topic.list"}}, kAnswerLimit);
  if (!reply) return complain(reply.error());
  if (wish.as_json) {
    std::printf("%s\n", reply.value()["topics"].dump().c_str());
    return kDone;
  }
  // As ros2 does: each name once, with all of its types.
  std::map<std::string, std::set<std::string>> types;
  for (const auto& row : reply.value()["topics"]) types[row["name"]].insert(row["type"].get<std::string>());
  for (const auto& [name, of_name] : types) {
    const std::string all = join({of_name.begin(), of_name.end()});
    std::printf(wish.with_types ? "%s [%s]\n" : "%s\n", name.c_str(), all.c_str());
  }
  return kDone;
}

std::string absolute(const std::string& topic) { return topic.rfind('/', 0) == 0 ? topic : "/" + topic; }

/// Listens to a topic and gives each item to `take` until that answers false, a signal comes or the container ends.
template <typename Take>
int listen(const Wish& wish, const char* show, Take&& take) {
  const session::StopSignal stop;
  auto client = connect(wish.container);
  if (!client) return client.error();
  json request{{"verb", "topic.listen"}, {"topic", absolute(wish.topic)}, {"show", show}};
  if (!wish.type.empty()) request["type"] = wish.type;
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

int echo(const Wish& wish) {
  return listen(wish, wish.as_json ? "json" : "yaml", [&](std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fputs(wish.as_json ? "\n" : "---\n", stdout);
    std::fflush(stdout);
    return !wish.once;
  });
}

int hz(const Wish& wish) {
  std::deque<double> times_s;
  double shown_at_s = 0;
  return listen(wish, "times", [&](std::string_view text) {
    std::int64_t ns = 0;
    if (std::from_chars(text.data(), text.data() + text.size(), ns).ec != std::errc{}) return true;
    const double now_s = static_cast<double>(ns) * 1e-9;
    times_s.push_back(now_s);
    if (times_s.size() > wish.window + 1) times_s.pop_front();
    if (shown_at_s == 0) shown_at_s = now_s;
    if (now_s - shown_at_s < 1.0 || times_s.size() < 2) return true;
    shown_at_s = now_s;
    const double n = static_cast<double>(times_s.size() - 1), mean_s = (times_s.back() - times_s.front()) / n;
    double least_s = INFINITY, most_s = 0, squares = 0;
    for (std::size_t i = 1; i < times_s.size(); ++i) {
      const double gap_s = times_s[i] - times_s[i - 1];
      least_s = std::min(least_s, gap_s);
      most_s = std::max(most_s, gap_s);
      squares += (gap_s - mean_s) * (gap_s - mean_s);
    }
    // ros2 topic hz's lines.
    std::printf("average rate: %.3f\n\tmin: %.3fs max: %.3fs std dev: %.5fs window: %zu\n", 1.0 / mean_s, least_s,
                most_s, std::sqrt(squares / n), times_s.size() - 1);
    std::fflush(stdout);
    return !wish.once;
  });
}

int publish(const Wish& wish) {
  const session::StopSignal stop;
  msgs::TypeLibrary library{program_places().message_folders};
  auto type = library.message(wish.type);
  if (!type) return complain(type.error());
  msgs::AnyMessage message{*type.value()};
  if (auto read = msgs::from_json(wish.message, *type.value(), message.get()); !read) return complain(read.error());
  const Bytes cdr = message.encoded();

  auto client = connect(wish.container);
  if (!client) return client.error();
  auto handle = client.value().open_writer(absolute(wish.topic), wish.type, kAnswerLimit);
  if (!handle) return complain(handle.error());
  const SystemClock clock;
  MonotonicTime next = clock.now();
  const Duration period = from_seconds(1.0 / wish.rate_hz);
  for (std::size_t sent = 0; !stop.is_raised() && (wish.times == 0 || sent < wish.times); ++sent) {
    if (auto done = client.value().publish(handle.value(), cdr); !done) return complain(done.error());
    std::printf("publishing #%zu: %s\n", sent + 1, wish.message.c_str());
    std::fflush(stdout);
    // Refusals come as faults; asking for something shows that the message was taken.
    if (auto taken = client.value().stats(kAnswerLimit); !taken) return complain(taken.error());
    if (wish.times != 0 && sent + 1 == wish.times) break;
    next += period;
    while (!stop.is_raised() && clock.now() < next) {
      pollfd wait{stop.descriptor(), POLLIN, 0};
      ::poll(&wait, 1, static_cast<int>((next - clock.now()) / 1ms) + 1);
    }
  }
  return kDone;
}

}  // namespace

void add_topic_commands(Command& root) {
  Command& group = root.add("topic", "list, watch, measure and write topics of a running container");
  auto wish = std::make_shared<Wish>();

  Command& list_command = group.add("list", "the topics");
  add_container_option(list_command, wish->container);
  list_command.flag("-t,--show-types", wish->with_types, "the types too");
  list_command.flag("--json", wish->as_json, "types and counts as JSON");
  list_command.runs([wish] { return list(*wish); });

  Command& echo_command = group.add("echo", "show a topic's messages");
  add_container_option(echo_command, wish->container);
  echo_command.option("topic", wish->topic, "").required().names_a(Names::Topic);
  echo_command.option("type", wish->type, "of a topic with several: the one to show").names_a(Names::Type);
  echo_command.flag("--once", wish->once, "one message, then end");
  echo_command.flag("-f,--full,--full-length", wish->full, "long sequences and texts whole");
  echo_command.flag("--json", wish->as_json, "one JSON object a line, always whole");
  echo_command.runs([wish] { return echo(*wish); });

  Command& hz_command = group.add("hz", "measure a topic's rate");
  add_container_option(hz_command, wish->container);
  hz_command.option("topic", wish->topic, "").required().names_a(Names::Topic);
  hz_command.option("type", wish->type, "of a topic with several: the one to measure").names_a(Names::Type);
  hz_command.option("-w,--window", wish->window, "how many messages the rate is taken over")
      .within(2, 100000)
      .with_default();
  hz_command.flag("--once", wish->once, "one figure, then end");
  hz_command.runs([wish] { return hz(*wish); });

  Command& pub_command = group.add("pub", "publish a message");
  add_container_option(pub_command, wish->container);
  pub_command.option("topic", wish->topic, "").required().names_a(Names::Topic);
  pub_command.option("type", wish->type, "e.g. geometry_msgs/msg/Twist").required().names_a(Names::Type);
  pub_command.option("message", wish->message, "JSON; missing fields take their defaults");
  pub_command.option("-r,--rate", wish->rate_hz, "messages per second").within(0.001, 1000).with_default();
  pub_command.option("-t,--times", wish->times, "end after this many (0: until Ctrl-C)");
  pub_command.flag(
      "-1,--once", [wish] { wish->times = 1; }, "one message, then end");
  pub_command.runs([wish] { return publish(*wish); });
}

}  // namespace nacelle::cli
