// SPDX-License-Identifier: Apache-2.0
// What goes to a topic from the command line.
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/topic_commands.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "process/stop_signal.hpp"
#include "text/message_text.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

void wait_until(MonotonicTime until, const process::StopSignal& stop, const Clock& clock) {
  while (!stop.is_raised() && clock.now() < until) {
    pollfd wait{stop.descriptor(), POLLIN, 0};
    ::poll(&wait, 1, static_cast<int>((until - clock.now()) / 1ms) + 1);
  }
}

/// The subscriptions that a message of that topic and type goes to. On a connection of its own: one that has asked cannot publish.
Result<json, Problem> readers_of(control::Client& asking, const TopicWish& wish, Duration limit) {
  auto graph = ask::Nodes{asking, limit, 0s}.graph();
  if (!graph) return err(graph.error());
  json readers = json::array();
  for (const auto& end : graph.value()["endpoints"]) {
    if (!end["publisher"].get<bool>() && end["topic"] == absolute(wish.topic) && end["type"] == wish.type)
      readers.push_back(end);
  }
  return readers;
}

/// A reader that stops when messages stop, and these come too seldom for it, stops and goes.
void warn_if_too_slow(const TopicWish& wish) {
  // Does not wait for a busy container: the message may be one that stops the robot.
  constexpr Duration kPatience = 200ms;
  auto asking = connect(wish.whom);
  if (!asking) return;
  const auto readers = readers_of(asking.value(), wish, kPatience);
  if (!readers) return;
  for (const auto& reader : readers.value()) {
    const double timeout_s = reader.value("command_timeout_s", 0.0);
    // Twice in its time: one message that is late, or lost, must not stop it.
    const double enough_hz = timeout_s > 0 ? 2.0 / timeout_s : 0.0;
    if (wish.rate_hz >= enough_hz) continue;
    std::fprintf(stderr,
                 "nacelle: warning: %s: %s stops %g s after the last message (its parameter %s), and %g Hz %s; "
                 "publish with --rate %g or more\n",
                 absolute(wish.topic).c_str(), text_of(reader, "node").c_str(), timeout_s,
                 text_of(reader, "command_parameter").c_str(), wish.rate_hz,
                 wish.rate_hz * timeout_s <= 1.0 ? "makes it stop and go" : "leaves no room for a late one",
                 std::ceil(enough_hz * 1e3) / 1e3);
  }
}

/// Returns the problem of a topic that exists only with other types, where no reader could receive the messages.
/// Nothing if it may be published.
std::optional<Problem> clash_of(control::Client& client, const TopicWish& wish) {
  // Through the control thread, which answers even if the container is busy: the message may be one that stops the
  // robot.
  const auto stats = client.stats(kAnswerLimit);
  if (!stats) return stats.error();
  const json parsed = parse_json_or_discard(stats.value());
  if (!parsed.is_object()) return std::nullopt;
  const auto types = texts_of(parsed.value("streams", json::array()), "type", [&](const json& stream) {
    return text_of(stream, "name") == absolute(wish.topic) &&
           stream.value("readers", 0U) + stream.value("writers", 0U) != 0;
  });
  if (types.empty() || std::ranges::count(types, wish.type) != 0) return std::nullopt;
  return Problem{"topic " + absolute(wish.topic), "has the type " + join(types, " and ") + ", not " + wish.type,
                 "publish that type, or on another topic"};
}

/// Waits for --wait-matching-subscriptions. Returns the exit code, or nothing when publishing may begin.
std::optional<int> wait_for_readers(const TopicWish& wish, const process::StopSignal& stop, const Clock& clock) {
  auto asking = connect(wish.whom);
  if (!asking) return asking.error();
  constexpr Duration kLook = 100ms;
  const MonotonicTime began = clock.now();
  for (MonotonicTime told{};;) {
    auto readers = readers_of(asking.value(), wish, kAnswerLimit);
    if (!readers) return complain(readers.error());
    if (readers.value().size() >= wish.readers) return std::nullopt;
    if (stop.is_raised()) return kDone;
    if (told == MonotonicTime{} || clock.now() - told >= 1s) {
      std::fprintf(stderr, "Waiting for at least %zu matching subscription(s)...\n", wish.readers);
      told = clock.now();
    }
    if (wish.longest_wait_s > 0 && clock.now() - began >= from_seconds(wish.longest_wait_s)) {
      return complain(
          {"Timed out waiting for subscribers",
           fmt::format("Expected {} subscribers but only got {} subscribers", wish.readers, readers.value().size()),
           "see " + wish.whom.command("topic info " + absolute(wish.topic))});
    }
    wait_until(clock.now() + kLook, stop, clock);
  }
}

/// Returns the message to send now. Errors: the mistake in the text.
Result<bool, Problem> fill(msgs::AnyMessage& message, const std::string& text, const Clock& clock) {
  auto read = text::read_message_text(text, message.type(), clock.wall_now());
  if (!read) return err(read.error());
  if (auto done = msgs::from_json(read.value().json, message.type(), message.get()); !done) return err(done.error());
  return read.value().has_stamps;
}

/// Returns false if the output is closed.
bool show(const TopicWish& wish, const msgs::AnyMessage& message, std::size_t number) {
  if (wish.print_every == 0 || number % wish.print_every != 0) return true;
  if (wish.as_json) {
    std::printf("%s\n", msgs::to_json(message.type(), message.get()).c_str());
  } else {
    std::string text;
    text::append_repr(text, message.type(), message.get());
    std::printf("publishing #%zu: %s\n\n", number, text.c_str());
  }
  return flush_output();
}

}  // namespace

int publish_topic(const TopicWish& asked) {
  if (complain_of_topic_name(asked.topic)) return kUsage;
  TopicWish wish = asked;
  wish.type = full_type_name(asked.type, "msg");
  const process::StopSignal stop{nullptr, process::FullOutput::Dropped};
  const SystemClock clock;
  msgs::TypeLibrary library{program_places().message_folders};
  auto type = library.message(wish.type);
  if (!type) return complain(type.error());
  msgs::AnyMessage message{*type.value()};
  auto stamped = fill(message, wish.message, clock);
  if (!stamped) return complain_of_usage(stamped.error());

  auto connected = connect(wish.whom);
  if (!connected) return connected.error();
  control::Client& client = connected.value();
  if (const auto clash = clash_of(client, wish)) {
    if (!wish.whom.is_remote()) return complain(*clash);
    // There a node that reads several types shows the one that is published (nacelle/qos/announced.hpp).
    std::fprintf(stderr, "nacelle: warning: %s %s; only a node that reads both, as Nacelle's base does, hears this\n",
                 clash->where.text().c_str(), clash->what.c_str());
  }
  // Before the wait: a reader of several types may show itself only when it sees a publisher of its type.
  auto handle = client.open_writer(absolute(wish.topic), wish.type, kAnswerLimit);
  if (!handle) return complain(handle.error());
  if (wish.readers != 0) {
    if (const auto ended = wait_for_readers(wish, stop, clock)) return *ended;
  }
  if (!wish.as_json) std::printf("publisher: beginning loop\n");
  MonotonicTime next = clock.now();
  const Duration period = from_seconds(1.0 / wish.rate_hz);
  for (std::size_t sent = 0; !stop.is_raised() && (wish.times == 0 || sent < wish.times); ++sent) {
    // Also the first one: finding the other side took its time.
    if (stamped.value()) static_cast<void>(fill(message, wish.message, clock));
    if (auto done = client.publish(handle.value(), message.encoded()); !done) return complain(done.error());
    if (!show(wish, message, sent + 1)) break;
    // Refusals come as faults; asking for something shows that the message was taken.
    if (auto taken = client.stats(kAnswerLimit); !taken) return complain(taken.error());
    if (wish.times != 0 && sent + 1 == wish.times) break;
    if (sent == 0) warn_if_too_slow(wish);
    wait_until(next += period, stop, clock);
  }
  return kDone;
}

}  // namespace nacelle::cli
