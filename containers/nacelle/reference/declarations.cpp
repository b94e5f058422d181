// SPDX-License-Identifier: Apache-2.0
#include "reference/declarations.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/host/action_names.hpp"
#include "nacelle/launch/parameter_value.hpp"
#include "nacelle/qos/text.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/plugin_fault.hpp"
#include "requests/qos_json.hpp"

namespace nacelle::reference {
namespace {

using nlohmann::json;

// In a namespace, and of a node with a name that no class uses, a name shows how it was written: relative, private or absolute.
constexpr const char* kNamespace = "/reference";
constexpr const char* kNode = "node_of_reference";

constexpr const char* kLists[] = {"publishes", "subscribes", "services", "clients",
                                  "actions",   "transforms", "devices",  "parameters"};

std::string as_written(const std::string& full, const std::string& node) {
  for (const auto& [front, written] : {std::pair{node + "/", "~/"}, {std::string{kNamespace} + "/", ""}}) {
    if (full.starts_with(front)) return written + full.substr(front.size());
  }
  return full;
}

void add_once(json& list, json row) {
  if (std::ranges::find(list, row) == list.end()) list.push_back(std::move(row));
}

std::string qos_text(QoS qos) {
  if (qos.liveliness() == Liveliness::Automatic)
    qos.liveliness(Liveliness::SystemDefault);  // the usual one is left out
  return to_text(qos);
}

void add_topics(json& all, const runtime::Container& container, const std::string& node) {
  for (const auto& end : container.endpoints()) {
    if (end.node != node) continue;
    if (const auto action = action::action_of_topic(end.topic, end.type); action && end.is_writer)
      add_once(all["actions"], {{"name", as_written(action->name, node)}, {"type", action->type}});
    if (action::is_action_part(end.topic)) continue;
    add_once(all[end.is_writer ? "publishes" : "subscribes"], {{"name", as_written(end.topic, node)},
                                                               {"type", end.type},
                                                               {"qos", requests::json_of(end.qos)},
                                                               {"qos_text", qos_text(end.qos)}});
  }
}

void add_services(json& all, const runtime::Container& container, const std::string& node) {
  for (const auto& end : container.services()) {
    if (end.node != node || end.is_standard || action::is_action_part(end.name)) continue;
    add_once(all[end.is_server ? "services" : "clients"], {{"name", as_written(end.name, node)}, {"type", end.type}});
  }
}

void add_transforms(json& all, const runtime::Container& container) {
  for (const auto& frame : container.frames()) {
    add_once(all["transforms"], {{"parent", frame.parent},
                                 {"child", frame.child},
                                 {"if_no_other_node_does", frame.kind == FrameClaimKind::Fallback},
                                 {"parameter", frame.origin.parameter}});
  }
}

json range_of(const ParameterDescriptor& descriptor) {
  if (const auto& range = descriptor.integer_range)
    return {{"from", range->from}, {"to", range->to}, {"step", range->step}};
  if (const auto& range = descriptor.floating_point_range)
    return {{"from", range->from}, {"to", range->to}, {"step", range->step}};
  return nullptr;
}

json row_of(const runtime::Declarations::Value& parameter) {
  const ParameterDescriptor& descriptor = parameter.descriptor;
  // A given value hides the default; a parameter that is not set has none.
  const bool has_default = !parameter.given && type_of(parameter.value) != ParameterType::NotSet;
  return {{"name", parameter.name},
          {"type", to_text(parameter.type)},
          {"default", has_default ? json(launch::to_text(parameter.value)) : json(nullptr)},
          {"range", range_of(descriptor)},
          {"constraints", descriptor.additional_constraints},
          {"read_only", descriptor.read_only},
          {"description", descriptor.description}};
}

runtime::ContainerOptions options_of(const loading::ProgramPlaces& places) {
  runtime::ContainerOptions options;
  options.name = "reference";
  options.component_path = places.component_folders;
  return options;
}

/// The node's name where the launch file gives none.
Result<std::string, Problem> default_name(const std::string& plugin, const loading::ProgramPlaces& places,
                                          const Clock& clock) {
  runtime::Container container{options_of(places), clock};
  runtime::LoadRequest request;
  request.plugin = plugin;
  request.faults = std::make_shared<ParameterFaults>();
  const auto loaded = container.load(request);
  if (!loaded) return err(loaded.error());
  return loaded.value().node.substr(1);
}

/// The rows of all lists of a class, loaded with these parameters.
Result<json, Problem> load(const std::string& plugin, const std::map<std::string, ParameterValue>& parameters,
                           const loading::ProgramPlaces& places, const Clock& clock) {
  runtime::Container container{options_of(places), clock};
  runtime::LoadRequest request;
  request.name = kNode;
  request.plugin = plugin;
  request.name_space = kNamespace;
  request.parameters = parameters;
  request.faults = std::make_shared<ParameterFaults>();  // parameters that a launch must give are absent
  const auto loaded = container.load(request);
  if (!loaded) return err(loaded.error());
  const runtime::ComponentInfo& info = loaded.value();

  json all{{"managed", info.managed}};
  for (const char* const list : kLists) all[list] = json::array();
  add_topics(all, container, info.node);
  add_services(all, container, info.node);
  add_transforms(all, container);
  for (const auto& use : info.declared->device_uses) add_once(all["devices"], use.parameter);
  for (const auto& parameter : info.declared->parameters) all["parameters"].push_back(row_of(parameter));
  return all;
}

Result<std::map<std::string, ParameterValue>, Problem> parse(const std::string& plugin, std::istringstream lines) {
  std::map<std::string, ParameterValue> parameters;
  for (std::string line; std::getline(lines, line);) {
    auto assignment = launch::parse_parameter_assignment(line);
    if (!assignment)
      return err(Problem{plugin,
                         "its ComponentAbout::also_with has the line '" + line + "': " + assignment.error().what,
                         assignment.error().way_out});
    parameters.insert(std::move(assignment).value());
  }
  return parameters;
}

/// Removes rows that `known` has; of parameters, those that it has by name.
void keep_new(json& all, const json& known) {
  for (const char* const list : kLists) {
    json rows = json::array();
    for (json& row : all[list]) {
      const bool is_known = std::ranges::any_of(known[list], [&](const json& other) {
        return list == std::string_view{"parameters"} ? other["name"] == row["name"] : other == row;
      });
      if (!is_known) rows.push_back(std::move(row));
    }
    all[list] = std::move(rows);
  }
}

}  // namespace

Result<json, Problem> declarations_of(const runtime::PluginEntry& plugin, const loading::ProgramPlaces& places,
                                      const Clock& clock) {
  const auto own_name = default_name(plugin.class_name, places, clock);
  if (!own_name) return err(own_name.error());
  auto all = load(plugin.class_name, {}, places, clock);
  if (!all) return all;
  json& told = all.value();
  told["node"] = own_name.value();
  const auto library = runtime::PluginLibrary::open(plugin.file);
  if (!library) return err(library.error());
  const ComponentClass* const made_by = library.value()->find(plugin.class_name);
  if (made_by == nullptr)
    return err(Problem{Place(plugin.file, 0), "holds no class " + plugin.class_name, "build it again",
                       runtime::PluginFault::ClassNotInLibrary, plugin.class_name});
  const ComponentAbout& about = made_by->about;
  told["plugin"] = plugin.class_name;
  told["package"] = plugin.package;
  told["purpose"] = about.purpose;
  told["devices_text"] = about.devices;
  told["with_parameters"] = json::array();
  const auto more = parse(plugin.class_name, std::istringstream{about.also_with});
  if (!more) return err(more.error());
  if (more.value().empty()) return all;
  auto also = load(plugin.class_name, more.value(), places, clock);
  if (!also) return also;
  keep_new(also.value(), told);
  for (const auto& [name, value] : more.value())
    told["with_parameters"].push_back(name + ":=" + launch::to_text(value));
  told["also"] = std::move(also).value();
  return all;
}

}  // namespace nacelle::reference
