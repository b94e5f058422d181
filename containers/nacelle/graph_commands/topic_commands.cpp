// SPDX-License-Identifier: Apache-2.0
#include "graph_commands/topic_commands.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <map>
#include <memory>
#include <utility>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/msgs/type_library.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;
using Wish = TopicWish;

std::vector<std::string> topics_with(const json& endpoints, const std::function<bool(const json&)>& fits) {
  return texts_of(endpoints, "topic", fits);
}

std::vector<std::string> types_of(const json& endpoints, const std::string& topic) {
  return texts_of(endpoints, "type", [&](const json& end) { return end["topic"] == topic; });
}

/// ros2's second form of the list: published and subscribed topics.
void print_both_sides(const json& endpoints, bool all) {
  for (const bool publisher : {true, false}) {
    print_text(publisher ? "Published topics:\n" : "\nSubscribed topics:\n");
    const auto of_side = [&](const json& end) {
      return end["publisher"] == publisher && (all || !is_hidden(text_of(end, "topic")));
    };
    for (const auto& topic : topics_with(endpoints, of_side)) {
      const auto count = std::ranges::count_if(
          endpoints, [&](const json& end) { return end["topic"] == topic && end["publisher"] == publisher; });
      print_text(" * %s [%s] %zd %s%s\n", topic.c_str(), join(types_of(endpoints, topic)).c_str(), count,
                 publisher ? "publisher" : "subscriber", count == 1 ? "" : "s");
    }
  }
}

/// Each topic with each of its types: how many publish it and how many read it.
json rows_of(const json& endpoints) {
  std::map<std::pair<std::string, std::string>, std::array<std::size_t, 2>> ends;
  for (const json& end : endpoints)
    ++ends[{text_of(end, "topic"), text_of(end, "type")}][end["publisher"] == true ? 0 : 1];
  json rows = json::array();
  for (const auto& [name, count] : ends)
    rows.push_back({{"name", name.first}, {"type", name.second}, {"writers", count[0]}, {"readers", count[1]}});
  return rows;
}

int list(const Wish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const json& endpoints = graph.value()["endpoints"];
  if (wish.as_json && !wish.only_count) {
    std::printf("%s\n", rows_of(endpoints).dump().c_str());
    return kDone;
  }
  const auto names =
      topics_with(endpoints, [&](const json& end) { return wish.all || !is_hidden(text_of(end, "topic")); });
  if (wish.verbose) {
    print_both_sides(endpoints, wish.all);
  } else if (wish.with_types && !wish.only_count) {
    // As ros2 does: each name once, with all of its types.
    for (const auto& name : names) print_text("%s [%s]\n", name.c_str(), join(types_of(endpoints, name)).c_str());
  } else {
    print_names(names, wish.only_count, wish.as_json);
  }
  return kDone;
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string words_of_time(const json& seconds) {
  if (seconds.is_null()) return "Infinite";
  return std::to_string(from_seconds(seconds.get<double>()).count()) + " nanoseconds";
}

/// As ros2 prints an identifier: bytes in hexadecimal with dots.
std::string words_of_id(std::uint64_t id) {
  std::string text;
  for (int shift = 56; shift >= 0; shift -= 8) {
    char byte[4];
    std::snprintf(byte, sizeof byte, "%02x%s", static_cast<unsigned>(id >> shift & 0xFFU), shift == 0 ? "" : ".");
    text += byte;
  }
  return text;
}

void print_end(const json& end) {
  const std::string node = text_of(end, "node");
  const auto slash = node.rfind('/');
  const json& qos = end["qos"];
  print_text("Node name: %s\nNode namespace: %s\nTopic type: %s\nTopic type hash: %s\nEndpoint type: %s\nGID: %s\n",
             node.substr(slash + 1).c_str(), slash == 0 ? "/" : node.substr(0, slash).c_str(),
             text_of(end, "type").c_str(), text_of(end, "hash").c_str(),
             end["publisher"].get<bool>() ? "PUBLISHER" : "SUBSCRIPTION",
             end.value("gid", words_of_id(end["id"].get<std::uint64_t>())).c_str());
  std::string history = upper(text_of(qos, "history"));
  if (history == "KEEP_LAST") history += " (" + qos["depth"].dump() + ")";
  print_text(
      "QoS profile:\n  Reliability: %s\n  History (Depth): %s\n  Durability: %s\n  Lifespan: %s\n"
      "  Deadline: %s\n  Liveliness: %s\n  Liveliness lease duration: %s\n",
      upper(text_of(qos, "reliability")).c_str(), history.c_str(), upper(text_of(qos, "durability")).c_str(),
      words_of_time(qos["lifespan_s"]).c_str(), words_of_time(qos["deadline_s"]).c_str(),
      upper(text_of(qos, "liveliness")).c_str(), words_of_time(qos["liveliness_lease_s"]).c_str());
  if (end.contains("command_timeout_s"))
    print_text("Command timeout: %g s (parameter %s)\n", end["command_timeout_s"].get<double>(),
               text_of(end, "command_parameter").c_str());
  if (end["elsewhere"].get<bool>()) std::printf("Process: another one\n");
  std::printf("\n");
}

/// One type as it is; several as Python's list, as ros2 prints them.
std::string words_of_types(const std::vector<std::string>& types) {
  return types.size() == 1 ? types.front() : "['" + join(types, "', '") + "']";
}

int info(const Wish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const json& endpoints = graph.value()["endpoints"];
  const std::string topic = absolute(wish.topic);
  const auto types = types_of(endpoints, topic);
  if (types.empty()) return complain_unknown("topic", topic, topics_with(endpoints, [](const json&) { return true; }));
  json publishers = json::array(), subscriptions = json::array();
  for (const auto& end : endpoints) {
    if (end["topic"] == topic) (end["publisher"].get<bool>() ? publishers : subscriptions).push_back(end);
  }
  if (wish.as_json) {
    std::printf("%s\n",
                json{{"topic", topic}, {"types", types}, {"publishers", publishers}, {"subscriptions", subscriptions}}
                    .dump()
                    .c_str());
    return kDone;
  }
  const char* const gap = wish.verbose ? "\n" : "";
  print_text("Type: %s\n%sPublisher count: %zu\n%s", words_of_types(types).c_str(), gap, publishers.size(), gap);
  if (wish.verbose) std::ranges::for_each(publishers, print_end);
  print_text("Subscription count: %zu\n%s", subscriptions.size(), gap);
  if (wish.verbose) std::ranges::for_each(subscriptions, print_end);
  return kDone;
}

int show_type(const Wish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const json& endpoints = graph.value()["endpoints"];
  const auto types = types_of(endpoints, absolute(wish.topic));
  if (types.empty())
    return complain_unknown("topic", absolute(wish.topic), topics_with(endpoints, [](const json&) { return true; }));
  print_names(types, false, wish.as_json);
  return kDone;
}

int find(const Wish& wish) {
  msgs::TypeLibrary library{program_places().message_folders};
  auto type = library.message(full_type_name(wish.type, "msg"));
  if (!type) return complain(type.error());
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const auto fits = [&](const json& end) {
    return text_of(end, "type") == type.value()->name && (wish.all || !is_hidden(text_of(end, "topic")));
  };
  print_names(topics_with(graph.value()["endpoints"], fits), wish.only_count, wish.as_json);
  return kDone;
}

using WishPointer = std::shared_ptr<Wish>;

void add_lists(Command& group, const WishPointer& wish) {
  Command& list_command = group.add("list", "list the topics");
  list_command.flag("-t,--show-types", wish->with_types, "the types too");
  list_command.flag("-c,--count-topics", wish->only_count, "only how many");
  list_command.flag("-v,--verbose", wish->verbose, "list topics with their numbers of publishers and subscriptions");
  list_command.flag("--include-hidden-topics", wish->all, "include topics whose name has a part that begins with '_'");
  add_common_options(list_command, wish->whom, wish->as_json);
  list_command.runs([wish] { return list(*wish); });

  Command& info_command = group.add("info", "show the type of a topic and its numbers of publishers and subscriptions");
  info_command.option("topic", wish->topic, "").required().names_a(Names::Topic);
  info_command.flag("-v,--verbose", wish->verbose, "show each endpoint with its node and effective QoS");
  add_common_options(info_command, wish->whom, wish->as_json);
  info_command.runs([wish] { return info(*wish); });

  Command& type_command = group.add("type", "show the type of a topic");
  type_command.option("topic", wish->topic, "").required().names_a(Names::Topic);
  add_common_options(type_command, wish->whom, wish->as_json);
  type_command.runs([wish] { return show_type(*wish); });

  Command& find_command = group.add("find", "list the topics of a type");
  find_command.option("type", wish->type, "e.g. sensor_msgs/msg/LaserScan").required().names_a(Names::Type);
  find_command.flag("-c,--count-topics", wish->only_count, "only how many");
  find_command.flag("--include-hidden-topics", wish->all, "include topics whose name has a part that begins with '_'");
  add_common_options(find_command, wish->whom, wish->as_json);
  find_command.runs([wish] { return find(*wish); });
}

void add_listeners(Command& group, const WishPointer& wish) {
  Command& echo_command = group.add("echo", "show a topic's messages");
  echo_command.option("topic", wish->topic, "").required().names_a(Names::Topic);
  echo_command.option("type", wish->type, "the type to show, if the topic has several").names_a(Names::Type);
  echo_command.flag("--once", wish->once, "exit after one message");
  echo_command
      .option("--field", wish->field,
              "only this field of each message, e.g. pose.pose.position; strings are printed verbatim")
      .value("FIELD");
  echo_command.flag("-f,--full,--full-length", wish->full, "print long sequences and strings completely");
  echo_command.option("-l,--truncate-length", wish->longest, "maximum length of sequences and strings; 0: no limit")
      .value("N")
      .with_default()
      .not_with("--full");
  echo_command
      .flag("--raw", wish->is_raw,
            "print the bytes of each message in hexadecimal; works for types that are not installed")
      .not_with("--field");
  add_common_options(echo_command, wish->whom, wish->as_json);
  echo_command.flag("--csv", wish->as_csv, "print the values of each message on one line, separated by commas")
      .not_with("--json")
      .not_with("--raw");
  echo_command.runs([wish] { return echo_topic(*wish); });

  const auto add = [&](const char* name, const char* what, std::size_t window, int (*measure)(const Wish&)) {
    Command& command = group.add(name, what);
    // A target of its own: the three have defaults of their own.
    auto own = std::make_shared<Wish>();
    own->window = window;
    if (measure == measure_rate) {
      command
          .option("topics", own->words, "one or more topics; after a topic that has several types, the type to measure")
          .required()
          .names_a(Names::Topic);
    } else {
      command.option("topic", own->topic, "").required().names_a(Names::Topic);
      command.option("type", own->type, "the type to measure, if the topic has several").names_a(Names::Type);
    }
    command.option("-w,--window", own->window, "number of messages to average over").within(2, 100000).with_default();
    command.flag("--once", own->once, "print one figure and exit");
    add_common_options(command, own->whom, own->as_json);
    command.runs([own, measure] { return measure(*own); });
  };
  add("hz", "measure the rate of topics", 1000, measure_rate);
  add("bw", "measure the bandwidth of a topic", 100, measure_bandwidth);
  add("delay", "measure the age of header stamps at publication", 1000, measure_delay);
}

void add_publisher(Command& group, const WishPointer& wish) {
  Command& command = group.add("pub", "publish a message");
  command.option("topic", wish->topic, "").required().names_a(Names::Topic);
  command.option("type", wish->type, "e.g. geometry_msgs/msg/Twist").required().names_a(Names::Type);
  command.option(
      "message", wish->message,
      "YAML or JSON: {linear: {x: 0.1}}; missing fields take their defaults; a header may be auto, a stamp now");
  command.option("-r,--rate", wish->rate_hz, "messages per second").within(0.001, 1000).with_default();
  command.option("-t,--times", wish->times, "exit after this many messages (0: until Ctrl-C)").value("N");
  command
      .flag(
          "-1,--once", [wish] { wish->times = 1; }, "exit after one message")
      .not_with("--times");
  command.option("-w,--wait-matching-subscriptions", wish->readers, "wait for this many subscriptions first")
      .value("N");
  command.option("--max-wait-time-secs", wish->longest_wait_s, "stop waiting after this many seconds (0: never)")
      .value("SECONDS")
      .within(0, 86400);
  command.option("-p,--print", wish->print_every, "print only every N-th message; 0: none").value("N").with_default();
  add_common_options(command, wish->whom, wish->as_json);
  command.runs([wish] { return publish_topic(*wish); });
}

}  // namespace

void add_topic_commands(Command& root) {
  Command& group = root.add("topic", "list, show, measure and publish topics");
  auto wish = std::make_shared<Wish>();
  add_lists(group, wish);
  add_listeners(group, wish);
  add_publisher(group, wish);
}

}  // namespace nacelle::cli
