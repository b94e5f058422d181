// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/verbs.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "nacelle/control/client.hpp"
#include "nacelle/session/figures_verb.hpp"
#include "nacelle/session/graph_verbs.hpp"
#include "nacelle/session/load_request.hpp"
#include "nacelle/session/network_verbs.hpp"
#include "nacelle/session/service_verbs.hpp"
#include "nacelle/session/session.hpp"
#include "nacelle/session/tf_verbs.hpp"
#include "nacelle/session/wiring.hpp"

namespace nacelle::session {
namespace {

using control::reply_of;
using nlohmann::json;

json to_json(const runtime::ComponentInfo& info) {
  json row{{"id", info.id},           {"node", info.node},
           {"plugin", info.plugin},   {"library", info.library},
           {"managed", info.managed}, {"state", info.managed ? nacelle::to_text(info.state) : ""}};
  if (!info.fault.code.empty()) row["fault"] = {{"code", info.fault.code}, {"text", info.fault.text}};
  for (const auto& fault : info.open_faults) row["open_faults"].push_back({{"code", fault.code}, {"text", fault.text}});
  return row;
}

json list_components(Session& session) {
  json rows = json::array();
  for (const auto& info : session.container().list()) rows.push_back(to_json(info));
  // Apart from the components: there is nothing any more that one could talk to.
  json kept = json::array();
  for (const auto& image : session.container().kept_images()) {
    kept.push_back(
        {{"node", image.node}, {"plugin", image.plugin}, {"library", image.library}, {"held_by", image.held_by}});
  }
  return {{"ok", true}, {"container", session.options().container_name}, {"components", rows}, {"kept_images", kept}};
}

/// Loads, checks the new wiring, and takes the component to its state; undone if any of it fails.
/// `plan`: null for a plugin that the launch file does not name; then so many of its remaps, at the front, are the caller's.
json load(Session& session, const runtime::LoadRequest& request, launch::TargetState target,
          const launch::ComponentPlan* plan, std::size_t own_remaps = 0) {
  const GraphBefore before{session.container()};
  auto loaded = plan != nullptr ? session.load(*plan) : session.container().load(request);
  if (!loaded) return reply_of(loaded.error());
  const std::string node = loaded.value().node;
  std::vector<std::string> warnings = loaded.value().warnings;
  TopicEnds ends = before.added();
  if (const auto& declared = loaded.value().declared)
    ends.services = {declared->services.begin(), declared->services.end()};
  if (plan != nullptr) {
    for (const auto& problem : unused_qos(*plan, ends)) warnings.push_back(problem.text());
  } else if (loaded.value().declared) {
    for (const auto& unused : unused_remaps(request.remaps, loaded.value().declared->used_remaps, node, ends))
      if (unused.rule < own_remaps) warnings.push_back(unused.problem.text());
  }
  std::string clashes;
  for (const auto& clash : session.container().clashes()) {
    if (clash.writer_node != node && clash.reader_node != node) continue;
    // Whoever is on the network with whatever QoS keeps nothing from being loaded.
    const bool is_within = session.container().find(clash.writer_node).has_value() &&
                           session.container().find(clash.reader_node).has_value();
    if (is_within) {
      clashes.append(clashes.empty() ? "" : "; ").append(clash.text());
    } else {
      warnings.push_back(clash.text());
    }
  }
  Result<void, Problem> done{};
  if (!clashes.empty()) {
    done = err(Problem{node, clashes, ""});
  } else if (loaded.value().managed) {
    done = session.bring_to(loaded.value(), target);
  }
  if (!done) {
    static_cast<void>(session.container().unload(loaded.value().id));
    session.composition_changed();
    Problem problem = done.error();
    problem.way_out += problem.way_out.empty() ? "it was taken out again" : "; it was taken out again";
    // A name that nobody has may be why: with its default the component looked for another device.
    for (const auto& warning : warnings) problem.way_out += "; " + warning;
    return reply_of(problem);
  }
  session.composition_changed();
  json reply = to_json(session.container().find(node).value_or(loaded.value()));
  reply["warnings"] = warnings;
  reply["ok"] = true;
  return reply;
}

json load_by_name(Session& session, const json& request) {
  const std::string name = request.value("name", "");
  std::vector<std::string> names;
  for (const auto& component : session.plan().components) {
    names.push_back(component.name);
    if (component.full_name() == name || component.name == name)
      return load(session, load_request_of(component), component.target, &component);
  }
  return reply_of({"component " + name, "the launch file has no component of that name",
                   suggestion(name, names) + "; a plugin is loaded with its class and --name"});
}

}  // namespace

Result<runtime::LoadRequest, Problem> plugin_request_of(const json& request, const std::string& below) {
  runtime::LoadRequest wanted;
  wanted.plugin = request.value("plugin", "");
  wanted.name = request.value("name", "");
  wanted.name_space = join_namespaces(below, request.value("namespace", ""));
  if (wanted.name_space.empty()) wanted.name_space = "/";
  // The file first, single values over it: as ros2 component load does.
  if (request.contains("params_file")) {
    const std::string path = request["params_file"];
    // Opened by the command, with its rights and at its pace: the main thread waits for no file system.
    if (!request.contains("params_text"))
      return err(Problem{path.substr(0, 200), "comes without its text (params_text): the container opens no such file",
                         "use the `nacelle` that started the container"});
    auto parsed = launch::parse_parameter_file(request["params_text"].get_ref<const std::string&>(), path);
    if (!parsed) return err(parsed.error().front());
    for (const auto& parameter :
         parsed.value().parameters_for(fully_qualified_node_name(wanted.name_space, wanted.name))) {
      wanted.parameters[parameter.name] = parameter.value;
    }
  }
  for (const auto& text : request.value("parameters", json::array())) {
    auto parameter = launch::parse_parameter_assignment(text.get<std::string>());
    if (!parameter)
      return err(Problem{"-p " + text.get<std::string>(), parameter.error().what, parameter.error().way_out});
    wanted.parameters[parameter.value().first] = parameter.value().second;
  }
  for (const auto& text : request.value("remaps", json::array())) {
    auto rule = parse_remap_rule(text.get<std::string>());
    if (!rule) return err(Problem{"-r " + text.get<std::string>(), rule.error().what, rule.error().way_out});
    wanted.remaps.push_back(rule.value());
  }
  return wanted;
}

namespace {

json load_plugin(Session& session, const json& request) {
  const launch::NamespacePlan& names = session.plan().name_space;
  auto made = plugin_request_of(request, names.path);
  if (!made) return reply_of(made.error());
  runtime::LoadRequest wanted = std::move(made).value();
  if (const std::string prefix = names.frame_prefix(); !prefix.empty())
    wanted.parameters.emplace("frame_prefix", prefix);
  const std::size_t own_remaps = wanted.remaps.size();
  if (names.tf_topic() != "/tf") {
    wanted.remaps.push_back({RemapKind::Topic, "", "/tf", names.tf_topic()});
    wanted.remaps.push_back({RemapKind::Topic, "", "/tf_static", names.tf_topic() + "_static"});
  }
  return load(session, wanted, launch::TargetState::Active, nullptr, own_remaps);
}

/// Where the launch's namespace has put what tools look for.
json names_of(const Session& session) {
  const launch::NamespacePlan& names = session.plan().name_space;
  return {
      {"ok", true}, {"namespace", names.path}, {"tf_topic", names.tf_topic()}, {"frame_prefix", names.frame_prefix()}};
}

json unload(Session& session, const json& request) {
  auto component = session.container().find(request.value("name", ""));
  if (!component) return reply_of(component.error());
  auto outcome = session.container().unload(component.value().id);
  session.composition_changed();
  if (!outcome) return reply_of(outcome.error());
  return {{"ok", true},
          {"id", component.value().id},
          {"node", component.value().node},
          {"library", component.value().library},
          {"image_closed", outcome.value().image_closed},
          {"held_by", outcome.value().held_by}};
}

json lifecycle_get(Session& session, const json& request) {
  auto component = session.container().find(request.value("name", ""));
  if (!component) return reply_of(component.error());
  if (!component.value().managed) return reply_of({component.value().node, "is a plain node without a lifecycle", ""});
  return {{"ok", true},
          {"id", component.value().id},
          {"node", component.value().node},
          {"state", nacelle::to_text(component.value().state)},
          {"state_id", static_cast<int>(component.value().state)}};
}

json lifecycle_set(Session& session, const json& request) {
  auto component = session.container().find(request.value("name", ""));
  if (!component) return reply_of(component.error());
  Transition transition{};
  const std::string word = request.value("transition", "");
  if (!parse_transition(word, transition)) {
    return reply_of({"transition '" + word + "'", "there is no such transition",
                     suggestion(word, {"configure", "activate", "deactivate", "cleanup", "shutdown"})});
  }
  const TransitionOutcome outcome = session.container().trigger(component.value().id, transition);
  session.composition_changed();
  if (!outcome.success) {
    return reply_of({component.value().node,
                     std::string{"could not "} + nacelle::to_text(transition) + ": " + outcome.reason,
                     std::string{"it is "} + nacelle::to_text(outcome.state) + " now"});
  }
  return {{"ok", true}, {"node", component.value().node}, {"state", nacelle::to_text(outcome.state)}};
}

/// Answers with the full name of a component, or of another node here that offers a service.
json find_node(Session& session, const json& request) {
  const std::string name = request.value("name", "");
  const auto component = session.container().find(name);
  if (component) return {{"ok", true}, {"node", component.value().node}};
  for (const auto& service : session.container().services()) {
    if (service.is_server && (service.node == name || service.node.ends_with("/" + name)))
      return {{"ok", true}, {"node", service.node}};
  }
  return reply_of(component.error());
}

json list_topics(Session& session) {
  std::vector<runtime::StreamReport> streams;
  session.container().report_streams(streams);
  json rows = json::array();
  for (const auto& stream : streams) {
    if (stream.writers == 0 && stream.readers == 0) continue;  // a stream that was
    rows.push_back({{"name", stream.name},
                    {"type", stream.type},
                    {"writers", stream.writers},
                    {"readers", stream.readers},
                    {"published", stream.published},
                    {"delivered", stream.delivered},
                    {"copies", stream.copies},
                    {"hz", stream.hz()}});
  }
  std::sort(rows.begin(), rows.end(),
            [](const json& a, const json& b) { return a["name"].get<std::string>() < b["name"].get<std::string>(); });
  return {{"ok", true}, {"topics", rows}};
}

/// Returns true for a service that is named after a question: GetState, ListParameters, DescribeParameters.
bool only_reads(const std::string& service_type) {
  const std::string_view name = std::string_view{service_type}.substr(service_type.rfind('/') + 1);
  return name.starts_with("Get") || name.starts_with("List") || name.starts_with("Describe");
}

bool changes_something(const std::string& verb, const json& request) {
  if (verb == "service.call") return !only_reads(request.value("type", ""));
  return verb == "component.load" || verb == "component.load_plugin" || verb == "component.unload" ||
         verb == "lifecycle.set";
}

}  // namespace

Answer reply_to_verb(Session& session, msgs::TypeLibrary& types, const std::string& verb, const json& request) {
  if (changes_something(verb, request) && session.phase() != Phase::Running) {
    return reply_of({"container " + session.options().container_name, std::string{"it is "} + to_text(session.phase()),
                     "try again when it is running"});
  }
  if (verb == "component.list") return list_components(session);
  if (verb == "component.load") return load_by_name(session, request);
  if (verb == "component.load_plugin") return load_plugin(session, request);
  if (verb == "component.unload") return unload(session, request);
  if (verb == "lifecycle.get") return lifecycle_get(session, request);
  if (verb == "lifecycle.set") return lifecycle_set(session, request);
  if (verb == "faults") return session.faults();
  if (verb == "estop.list") return json{{"ok", true}, {"set", session.emergency_stops().set()}};
  if (verb == "topic.list") return list_topics(session);
  if (verb == "graph") return graph_of(session);
  if (verb == "component.info") return component_info(session, request);
  if (verb == "node.find") return find_node(session, request);
  if (verb == "service.prepare") return json{{"ok", true}};  // every server here is within reach
  if (verb == "service.call") {
    const auto start = [&](const auto&... given) { return session.container().call_service(given...); };
    return call_service(session.container().clock(), start, types, request, "see `nacelle faults`");
  }
  if (verb == "figures") return figures_of(session);
  if (verb == "names") return names_of(session);
  if (verb == "tf.tree" || verb == "tf.lookup") return reply_to_tf_verb(session, verb, request);
  if (verb.starts_with("network")) return reply_to_network_verb(session, verb, request);
  if (verb == "shutdown") {
    session.request_shutdown();
    return json{{"ok", true}};
  }
  return reply_of(
      {"request '" + verb + "'", "is unknown to this container", "use the `nacelle` that started the container"});
}

}  // namespace nacelle::session
