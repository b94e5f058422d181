// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <std_msgs/msg/bool.hpp>
#include <thread>
#include <vector>

#include "ask/faults.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "robot_commands/commands.hpp"
#include "session/robot_service.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

constexpr Duration kEstopLimit = 2s, kRemoteLimit = 10s;  // the second: for nodes of the network to be discovered
constexpr Duration kRepeatLimit = 3s, kRepeatPeriod = 50ms;

struct EstopWish {
  Whom whom;
  std::string topic;
  bool as_json = false;
};

struct Listener {
  std::string topic;
  std::size_t readers = 0;
};

/// Returns the emergency stop topics that have a reader.
std::vector<Listener> listeners_in(const std::string& stats) {
  std::vector<Listener> found;
  const json parsed = parse_json_or_discard(stats);
  for (const auto& stream : parsed.value("streams", json::array())) {
    const std::string name = stream.value("name", "");
    const auto readers = stream.value("readers", std::size_t{0});
    if (readers != 0 && session::is_emergency_stop(name, stream.value("type", ""))) found.push_back({name, readers});
  }
  return found;
}

int print_stops(const EstopWish& wish, bool set, const std::vector<Listener>& listeners) {
  json topics = json::array();
  for (const Listener& listener : listeners)
    topics.push_back({{"name", listener.topic}, {"readers", listener.readers}});
  if (wish.as_json) {
    std::printf("%s\n", json{{"emergency_stop", set}, {"topics", topics}}.dump().c_str());
    return kDone;
  }
  for (const Listener& listener : listeners) {
    print_text("%s %s, heard by %zu reader%s%s\n", listener.topic.c_str(), set ? "set" : "released", listener.readers,
               listener.readers == 1 ? "" : "s",
               set ? "" : "; the base moves again on a new command, after its input was zero or silent");
  }
  return kDone;
}

/// Sends the stops again until the container reports them, for at most kRepeatLimit. A reader that matches its writer late does not
/// receive earlier messages, and DDS does not report this to the writer (docs/adr/0013). Readers of other programs report nothing and
/// get the stop until the limit. A stop that is set already stays set.
template <typename Send>
Result<void, Problem> repeat_until_reported(control::Client& client, const EstopWish& wish,
                                            const std::vector<Listener>& listeners, const Send& send) {
  const SystemClock clock;
  ask::Nodes nodes{client};
  const MonotonicTime end = clock.now() + kRepeatLimit;
  while (true) {
    const auto reported = ask::emergency_stops(nodes, wish.whom.container);
    const auto is_set = [&](const Listener& listener) {
      return listener.readers == 0 ||
             (reported && std::ranges::find(reported.value(), listener.topic) != reported.value().end());
    };
    if (std::ranges::all_of(listeners, is_set) || clock.now() >= end) return {};
    std::this_thread::sleep_for(kRepeatPeriod);
    if (auto sent = send(); !sent) return sent;
  }
}

/// Through the control thread and not as a request: a container that is busy loading a component stops as quickly. `topic`: empty, or
/// the only one that is meant.
int tell(const EstopWish& wish, bool set, const std::string& topic) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  const Duration limit = wish.whom.is_remote() ? kRemoteLimit : kEstopLimit;
  auto stats = client.value().stats(limit);
  if (!stats) return complain(stats.error());
  std::vector<Listener> listeners = listeners_in(stats.value());
  if (!topic.empty()) {
    std::erase_if(listeners, [&](const Listener& listener) { return listener.topic != topic; });
    // Published nevertheless: a reader that joins later gets it.
    if (listeners.empty()) listeners.push_back({topic, 0});
  }
  if (listeners.empty()) {
    return complain({"emergency stop",
                     wish.whom.is_remote() ? "no node of the network reads a topic emergency_stop"
                                           : "no component of this container reads a topic emergency_stop",
                     "the base (nacelle::diff_drive::DiffDriveComponent) does; is it loaded?"});
  }
  std_msgs::msg::Bool message;
  message.data = set;
  const auto bytes = msgs::to_cdr(message);
  std::vector<std::uint16_t> writers;
  for (const Listener& listener : listeners) {
    auto handle = client.value().open_writer(listener.topic, session::kEmergencyStopType, limit);
    if (!handle) return complain(handle.error());
    if (auto sent = client.value().publish(handle.value(), bytes); !sent) return complain(sent.error());
    writers.push_back(handle.value());
  }
  // A refusal arrives as a fault. The reply to a request behind the messages shows that they were accepted.
  if (auto taken = client.value().stats(limit); !taken) return complain(taken.error());
  if (wish.whom.is_remote()) {
    const auto send_all = [&]() -> Result<void, Problem> {
      for (const auto writer : writers) {
        if (auto sent = client.value().publish(writer, bytes); !sent) return sent;
      }
      return {};
    };
    if (auto told = repeat_until_reported(client.value(), wish, listeners, send_all); !told)
      return complain(told.error());
  }
  return print_stops(wish, set, listeners);
}

/// By the container's service: a publisher that ends with this command cannot release a stop, since it is not latched.
int release_remotely(const EstopWish& wish, const std::string& topic) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  const auto released = ask::release_emergency_stops(nodes, wish.whom.container, topic);
  if (!released) return complain(released.error());
  std::vector<Listener> listeners;
  for (const json& row : released.value()["topics"]) listeners.push_back({row["name"], row["readers"]});
  return print_stops(wish, false, listeners);
}

int run_estop(const EstopWish& wish, bool set) {
  const std::string topic = wish.topic.empty() || wish.topic.front() == '/' ? wish.topic : "/" + wish.topic;
  if (!topic.empty() && !session::is_emergency_stop(topic, session::kEmergencyStopType)) {
    return complain_of_usage({"topic " + topic,
                              "is not an emergency stop: those end in " + std::string{session::kEmergencyStopTopic} +
                                  ", as /emergency_stop and /arm/emergency_stop do",
                              "without --topic every one that a component reads is meant"});
  }
  return wish.whom.is_remote() && !set ? release_remotely(wish, topic) : tell(wish, set, topic);
}

}  // namespace

void add_estop_command(Command& root) {
  Command& group = root.add("estop", "set or release the latched emergency stop");
  auto wish = std::make_shared<EstopWish>();
  for (const bool set : {true, false}) {
    Command& command = set ? group.add("set", "stop the wheels at once, until the stop is released")
                           : group.add("release", "release the stop; nothing moves before a new command arrives");
    command
        .option(
            "--topic", wish->topic,
            "set only this emergency stop, a topic whose last name is emergency_stop (default: each that a component "
            "reads)")
        .names_a(Names::Topic);
    add_common_options(command, wish->whom, wish->as_json);
    command.runs([wish, set] { return run_estop(*wish, set); });
  }
}

}  // namespace nacelle::cli
