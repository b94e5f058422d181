// SPDX-License-Identifier: Apache-2.0
#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/base/json_text.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "process/stop_signal.hpp"
#include "text/message_text.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct ServiceWish {
  Whom whom;
  std::string service, type, values = "{}";
  bool as_json = false, with_types = false, only_count = false, all = false;
  double rate_hz = 0.0, timeout_s = 10.0;
};

bool is_server(const json& row) { return row["server"].get<bool>(); }

int list(const ServiceWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const json& services = graph.value()["services"];
  const auto is_wanted = [&](const json& row) {
    return is_server(row) && (wish.all || !is_hidden(text_of(row, "name")));
  };
  const bool with_standard = wish.all || (wish.as_json && !wish.only_count);
  const auto shown = [&](const json& row) { return is_wanted(row) && (with_standard || !is_standard(row)); };
  if (!with_standard && !wish.only_count)
    tell_left_out(texts_of(services, "name", [&](const json& row) { return is_wanted(row) && !shown(row); }).size());
  const auto names = texts_of(services, "name", shown);
  if (wish.only_count || (!wish.as_json && !wish.with_types)) {
    print_names(names, wish.only_count, wish.as_json);
    return kDone;
  }
  json rows = json::array();
  for (const auto& name : names) {
    const auto of_name = [&](const json& row) { return shown(row) && text_of(row, "name") == name; };
    rows.push_back({{"name", name},
                    {"types", texts_of(services, "type", of_name)},
                    {"nodes", texts_of(services, "node", of_name)}});
    if (std::ranges::any_of(services, [&](const json& row) { return of_name(row) && is_standard(row); }))
      rows.back()["standard"] = true;
    if (!wish.as_json) print_text("%s [%s]\n", name.c_str(), join(texts_of(services, "type", of_name)).c_str());
  }
  if (wish.as_json) std::printf("%s\n", rows.dump().c_str());
  return kDone;
}

int show_type(const ServiceWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const json& services = graph.value()["services"];
  const std::string name = absolute(wish.service);
  const auto types = texts_of(services, "type", [&](const json& row) { return text_of(row, "name") == name; });
  if (types.empty()) return complain_unknown("service", name, texts_of(services, "name", is_server));
  print_names(types, false, wish.as_json);
  return kDone;
}

Result<const msgs::ServiceType*, Problem> service_type(msgs::TypeLibrary& library, const ServiceWish& wish) {
  auto found = library.find(full_type_name(wish.type, "srv"));
  if (!found) return err(found.error());
  if (found.value().service == nullptr)
    return err(Problem{found.value().name(), "is not a service", "see " + wish.whom.command("service list -t")});
  return found.value().service;
}

int find(const ServiceWish& wish) {
  msgs::TypeLibrary library{program_places().message_folders};
  auto type = service_type(library, wish);
  if (!type) return complain(type.error());
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const auto fits = [&](const json& row) {
    return is_server(row) && text_of(row, "type") == type.value()->name &&
           (wish.all || !is_hidden(text_of(row, "name")));
  };
  print_names(texts_of(graph.value()["services"], "name", fits), wish.only_count, wish.as_json);
  return kDone;
}

/// One call, shown as ros2 shows it. Errors: the exit code.
Result<void, int> call_once(const ServiceWish& wish, control::Client& client, const msgs::ServiceType& type) {
  msgs::AnyMessage request{type.request()};
  auto text = text::read_message_text(wish.values, type.request(), SystemClock{}.wall_now());
  if (!text) return err(complain_of_usage(text.error()));
  if (auto read = msgs::from_json(text.value().json, type.request(), request.get()); !read)
    return err(complain_of_usage(read.error()));
  if (!wish.as_json) {
    std::string shown;
    text::append_repr(shown, type.request(), request.get());
    print_text("requester: making request: %s\n\n", shown.c_str());
    std::fflush(stdout);
  }
  const json values = parse_json_or_discard(msgs::to_json(type.request(), request.get()));
  auto reply = client.call({{"verb", "service.call"},
                            {"service", absolute(wish.service)},
                            {"type", type.name},
                            {"request", values},
                            {"timeout_s", wish.timeout_s},
                            {"limit_option", "--timeout"}},
                           from_seconds(wish.timeout_s) + kAnswerLimit);
  if (!reply) return err(complain(reply.error()));
  const json& answer = reply.value()["response"];
  if (wish.as_json) {
    std::printf("%s\n", json{{"request", values}, {"response", answer}}.dump().c_str());
  } else {
    msgs::AnyMessage response{type.response()};
    if (auto read = msgs::from_json(answer.dump(), type.response(), response.get()); !read)
      return err(complain(read.error()));
    std::string shown;
    text::append_repr(shown, type.response(), response.get());
    print_text("response:\n%s\n\n", shown.c_str());
  }
  if (!flush_output()) return err(int{kDone});  // the output is closed: do not call again
  return {};
}

int call(const ServiceWish& wish) {
  msgs::TypeLibrary library{program_places().message_folders};
  auto type = service_type(library, wish);
  if (!type) return complain(type.error());
  auto client = connect(wish.whom);
  if (!client) return client.error();
  if (wish.rate_hz <= 0) {
    // A signal is not waited for: it ends the process, and with it the question.
    auto done = call_once(wish, client.value(), *type.value());
    return done ? kDone : done.error();
  }
  const process::StopSignal stop{nullptr, process::FullOutput::Dropped};
  const SystemClock clock;
  while (!stop.is_raised()) {
    const MonotonicTime began = clock.now();
    if (auto done = call_once(wish, client.value(), *type.value()); !done) return done.error();
    const MonotonicTime next = began + from_seconds(1.0 / wish.rate_hz);
    while (!stop.is_raised() && clock.now() < next) {
      pollfd wait{stop.descriptor(), POLLIN, 0};
      ::poll(&wait, 1, static_cast<int>((next - clock.now()) / 1ms) + 1);
    }
  }
  return kDone;
}

}  // namespace

Command& add_service_commands(Command& root) {
  Command& group =
      root.add("service", "list and call the services of a running container; run a robot as a service of systemd");
  auto wish = std::make_shared<ServiceWish>();

  Command& list_command = group.add("list", "list the services");
  list_command.flag("-t,--show-types", wish->with_types, "the types too");
  list_command.flag("-c,--count-services", wish->only_count, "only how many");
  list_command.flag("-a,--all,--include-hidden-services", wish->all,
                    "include services that every node has, and those whose name has a part that begins with '_'");
  add_common_options(list_command, wish->whom, wish->as_json);
  list_command.runs([wish] { return list(*wish); });

  Command& type_command = group.add("type", "show the type of a service");
  type_command.option("service", wish->service, "").required().names_a(Names::Service);
  add_common_options(type_command, wish->whom, wish->as_json);
  type_command.runs([wish] { return show_type(*wish); });

  Command& find_command = group.add("find", "list the services of a type");
  find_command.option("type", wish->type, "e.g. std_srvs/srv/Empty").required().names_a(Names::ServiceType);
  find_command.flag("-c,--count-services", wish->only_count, "only how many");
  find_command.flag("--include-hidden-services", wish->all,
                    "include services whose name has a part that begins with '_'");
  add_common_options(find_command, wish->whom, wish->as_json);
  find_command.runs([wish] { return find(*wish); });

  Command& call_command = group.add("call", "call a service and show its response");
  call_command.option("service", wish->service, "").required().names_a(Names::Service);
  call_command.option("type", wish->type, "e.g. std_srvs/srv/SetBool").required().names_a(Names::ServiceType);
  call_command.option("values", wish->values, "the request in YAML: {data: true}; missing fields take their defaults");
  call_command.option("-r,--rate", wish->rate_hz, "repeat the call this many times a second").within(0.001, 1000);
  call_command.option("--timeout", wish->timeout_s, "how long to wait for the response")
      .value("SECONDS")
      .within(0.001, 86400)
      .with_default();
  add_common_options(call_command, wish->whom, wish->as_json);
  call_command.runs([wish] { return call(*wish); });
  return group;
}

}  // namespace nacelle::cli
