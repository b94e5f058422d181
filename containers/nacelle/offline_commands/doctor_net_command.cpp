// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "ask/network.hpp"
#include "cli/inert_launch.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "control/socket_path.hpp"
#include "doctor/login_users.hpp"
#include "nacelle/base/problem_json.hpp"
#include "networking/network.hpp"
#include "networking/network_links.hpp"
#include "networking/network_wish.hpp"
#include "offline_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct NetWish {
  std::string file;
  std::vector<std::string> arguments;
  bool as_json = false;
};

json links_json() {
  json rows = json::array();
  for (const auto& link : networking::network_links())
    rows.push_back(
        {{"name", link.name}, {"up", link.up}, {"loopback", link.is_loopback}, {"addresses", link.addresses}});
  return rows;
}

Result<json, Problem> network_of(control::Client& client) {
  ask::Nodes nodes{client, 2s, 0s};
  return ask::get_network(nodes, "");
}

/// What the robots that run on this machine are shown to, and where it is something else than `here`.
json containers_json(const json& here) {
  json rows = json::array();
  for (const auto& found : trusted_containers()) {
    json row{{"name", found.name}, {"differs", json::array()}};
    auto client = control::Client::connect(found.path);
    auto reply = client ? network_of(client.value()) : err(client.error());
    if (!reply) {
      row["problem"] = reply.error();
      rows.push_back(std::move(row));
      continue;
    }
    for (const char* const key : {"mode", "domain", "line", "running", "problem", "interfaces", "peers", "exports",
                                  "security", "figures", "namesakes", "clock_skews"})
      row[key] = reply.value().value(key, json(nullptr));
    for (const char* const key : {"mode", "domain", "interfaces", "peers", "exports", "security"}) {
      if (here.contains(key) && row[key] != here[key]) row["differs"].push_back(key);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string words_of(const json& list, const char* empty) {
  const auto words = list.get<std::vector<std::string>>();
  return words.empty() ? empty : join(words);
}

std::string words_of_rule(const json& rule) {
  std::string text = rule["topic"].get<std::string>();
  if (!rule["max_hz"].is_null()) text += fmt::format(", at most {:g} Hz", rule["max_hz"].get<double>());
  if (!rule["max_bytes"].is_null()) text += fmt::format(", at most {} bytes/s", rule["max_bytes"].get<std::uint64_t>());
  if (rule["compressed_only"].get<bool>()) text += ", compressed only";
  return text;
}

void row(const char* key, const std::string& text) { print_text("%-11s %s\n", key, text.c_str()); }

std::string words_of_security(const json& security) {
  if (security.is_null()) return "none: not requested";
  const std::string keystore = security["keystore"].get<std::string>();
  const std::string text = security["enclave"].get<std::string>() + " of " +
                           (keystore.empty() ? "no keystore (ROS_SECURITY_KEYSTORE is not set)" : keystore) + ", " +
                           security["strategy"].get<std::string>();
  if (!security["in_force"].get<bool>()) return text + ": not in force";
  return text + "; certificate " + security["subject"].get<std::string>() + " until " +
         security["ends"].get<std::string>();
}

void print_settings(const json& net) {
  const std::string because_of = net["because_of"].get<std::string>();
  row("mode", net["mode"].get<std::string>() + " (" + (because_of.empty() ? "the default" : because_of) + ")");
  if (net["mode"] == "off") return;
  row("discovery", net["discovery"].get<std::string>());
  row("domain", fmt::format("{}, UDP ports {} to {}", net["domain"].get<int>(), net["ports"]["first"].get<int>(),
                            net["ports"]["last"].get<int>()));
  row("interfaces", words_of(net["interfaces"], "as Cyclone DDS chooses"));
  row("peers", words_of(net["peers"], "none"));
  if (net["mode"] == "export") {
    if (net["exports"].empty()) row("exports", "every topic");
    for (const auto& rule : net["exports"]) row("exports", words_of_rule(rule));
  }
  row("security", words_of_security(net["security"]));
  if (net["allow_load"].get<bool>()) row("allow_load", "others may load and unload components");
  if (net["remote_control"].get<bool>())
    row("control", "others may release emergency stops, change the network and end the robot");
  if (const auto uri = net["cyclonedds_uri"].get<std::string>(); !uri.empty()) row("CYCLONEDDS", uri);
}

std::string words_of_container(const json& container) {
  std::string text = container["name"].get<std::string>() + ": ";
  if (!container.contains("line")) return text + "does not answer";
  const std::string line = container["line"].get<std::string>();
  text += line.empty() ? "not on the network" : line;
  const auto differs = container["differs"].get<std::vector<std::string>>();
  if (!differs.empty()) text += " (not as here: " + join(differs) + ")";
  return text;
}

// "two of /ekf, /lidar: also in nacelle (process 77 on laptop)": a line for each other program, a second robot has all names.
std::vector<std::string> words_of_namesakes(const json& others) {
  std::map<std::string, std::vector<std::string>> nodes_of;
  for (const auto& other : others) {
    const auto said = [&](const char* key, const char* otherwise) {
      const auto text = other[key].get<std::string>();
      return text.empty() ? std::string(otherwise) : text;
    };
    nodes_of[fmt::format("{} (process {} on {})", said("process", "an unnamed program"), said("pid", "?"),
                         said("host", "an unnamed host"))]
        .push_back(other["node"].get<std::string>());
  }
  std::vector<std::string> lines;
  for (const auto& [program, nodes] : nodes_of)
    lines.push_back(
        fmt::format("two of {}: also in {}; put one into a namespace or another ROS_DOMAIN_ID", join(nodes), program));
  return lines;
}

// A network that is on without security does not ask a program of this machine whose it is.
std::string words_of_users(const json& net) {
  return words_of(net["other_users"], "") +
         " can log in on this machine, and may then set parameters, publish commands and deactivate the base of a "
         "robot "
         "that is started here; network:=off or security keeps them out (docs/security.md)";
}

void print(const json& net) {
  if (!net["built_in"].get<bool>())
    row("built", "without Cyclone DDS: no network; " + net["way_out"].get<std::string>());
  if (net.contains("mode") && net["built_in"] == true) print_settings(net);
  for (const auto& link : net["links"]) {
    row("link", fmt::format("{} {}{}", link["name"].get<std::string>(),
                            words_of(link["addresses"], "without an address"), link["up"].get<bool>() ? "" : ", down"));
  }
  for (const auto& container : net["containers"]) row("container", words_of_container(container));
  for (const auto& container : net["containers"]) {
    const auto rows_of = [&](const char* key) { return container.value(key, json::array()); };
    for (const auto& line : words_of_namesakes(rows_of("namesakes"))) row("node", line);
    for (const auto& skew : rows_of("clock_skews"))
      row("clock", container["name"].get<std::string>() + ": " + skew["text"].get<std::string>() +
                       "; synchronise both (chrony, or timedatectl set-ntp true)");
  }
  const auto print_problem = [](const char* key, const json& problem) { row(key, problem.get<Problem>().text()); };
  for (const auto& remark : net["remarks"]) print_problem("remark", remark);
  if (!net["other_users"].empty()) row("warning", words_of_users(net));
  if (!net["problem"].is_null()) print_problem("problem", net["problem"]);
}

/// What a robot would have with these settings; whether it can be had is tried.
json net_of(const Result<transport_dds::NetworkSettings, Problem>& settings) {
  const auto tried = settings ? networking::try_network(settings.value()) : err(settings.error());
  json net = settings ? networking::json_of(settings.value()) : json{{"remarks", json::array()}};
  net["problem"] = tried ? json(nullptr) : json(tried.error());
  if (!tried) {
    net["line"] = networking::network_off_line(tried.error());
    return net;
  }
  for (const auto& remark : tried.value()) net["remarks"].push_back(remark);
  return net;
}

bool is_open_to_other_users(const json& net) {
  if (net["built_in"] == false || !net.contains("mode") || net["mode"] == "off" || !net["problem"].is_null())
    return false;
  return net["security"].is_null() || !net["security"]["in_force"].get<bool>();
}

int examine(const NetWish& wish) {
  const auto arguments = parse_or_complain(wish.arguments);
  if (!arguments) return kUsage;
  launch::NetworkPlan plan;
  if (!wish.file.empty()) {
    auto loaded = launch::load_plan(wish.file, *arguments, launch_environment(program_places()));
    if (!loaded) {
      for (const auto& problem : loaded.error()) complain(problem);
      return kFailed;
    }
    plan = loaded.value().network;
  }
  json net = net_of(networking::network_in_force(plan, networking::ros_environment()));
  net["built_in"] = networking::network_is_built_in();
  if (!networking::network_is_built_in()) net["way_out"] = networking::network_is_not_built_in("").way_out;
  net["links"] = links_json();
  net["other_users"] = is_open_to_other_users(net)
                           ? doctor::other_login_users(doctor::Machine{doctor::real_facts("")}, ::getuid())
                           : std::vector<std::string>{};
  net["containers"] = containers_json(net);
  if (wish.as_json) {
    std::printf("%s\n", net.dump(2).c_str());
  } else {
    print(net);
  }
  return net["problem"].is_null() ? kDone : kFailed;
}

}  // namespace

void add_doctor_net_command(Command& doctor) {
  auto wish = std::make_shared<NetWish>();
  Command& command = doctor.add("net", "show who on the network could see a robot started here, and why");
  command.option("launch_file", wish->file, "with the network settings of this launch file").names_a(Names::File);
  command.option("arguments", wish->arguments, "name:=value for the file's arguments");
  command.flag("--json", wish->as_json, "print one JSON object");
  command.note(
      "Shows mode and domain with their origin, interfaces, peers, exports, ROS 2's variables that are not obeyed and\n"
      "why, other people who can log in here and reach the robot, and the settings of the running containers.\n"
      "See docs/network.md in the source tree. Joins the network briefly, without announcing itself, as a test.\n"
      "Exit codes: 0 success, 1 the launch file or environment is invalid or the network cannot be joined, 2 wrong "
      "usage.");
  command.runs([wish] { return examine(*wish); });
}

}  // namespace nacelle::cli
