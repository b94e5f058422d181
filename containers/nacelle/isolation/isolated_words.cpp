// SPDX-License-Identifier: Apache-2.0
#include "isolation/isolated_words.hpp"

#include <nlohmann/json.hpp>

#include "nacelle/base/problem_json.hpp"

namespace nacelle::isolation {

using nlohmann::json;

json faults_to_json(const std::vector<ParameterFault>& faults) {
  json rows = json::array();
  for (const auto& fault : faults) rows.push_back({fault.problem, fault.is_warning});
  return rows;
}

std::vector<ParameterFault> faults_from_json(const json& rows) {
  std::vector<ParameterFault> faults;
  for (const auto& row : rows) faults.push_back({row.at(0).get<Problem>(), row.at(1).get<bool>()});
  return faults;
}

json info_to_json(const runtime::ComponentInfo& info) {
  json row{{"node", info.node},         {"plugin", info.plugin},
           {"library", info.library},   {"state", static_cast<unsigned>(info.state)},
           {"managed", info.managed},   {"fault", {info.fault.code, info.fault.text}},
           {"warnings", info.warnings}, {"actuator", info.actuator}};
  row["open_faults"] = json::array();
  for (const auto& fault : info.open_faults) row["open_faults"].push_back({fault.code, fault.text});
  row["other_nodes"] = info.other_nodes;
  if (!info.declared) return row;
  json& declared = row["declared"];
  declared = {{"unknown", info.declared->unknown_parameters},
              {"services", info.declared->services},
              {"used_remaps", info.declared->used_remaps},
              {"package", info.declared->package}};
  declared["names"] = declared["frames"] = declared["devices"] = json::array();
  for (const auto& parameter : info.declared->parameters) declared["names"].push_back(parameter.name);
  for (const auto& use : info.declared->frame_uses) declared["frames"].push_back({use.frame, use.parameter});
  for (const auto& use : info.declared->device_uses) declared["devices"].push_back({use.path, use.parameter});
  return row;
}

runtime::ComponentInfo info_from_json(const json& row) {
  runtime::ComponentInfo info;
  info.node = row.at("node").get<std::string>();
  info.plugin = row.at("plugin").get<std::string>();
  info.library = row.at("library").get<std::string>();
  info.state = static_cast<StateId>(row.at("state").get<std::uint8_t>());
  info.managed = row.at("managed").get<bool>();
  info.fault = {row.at("fault").at(0).get<std::string>(), row.at("fault").at(1).get<std::string>()};
  info.warnings = row.at("warnings").get<std::vector<std::string>>();
  info.actuator = row.at("actuator").get<bool>();
  for (const auto& fault : row.at("open_faults"))
    info.open_faults.push_back({fault.at(0).get<std::string>(), fault.at(1).get<std::string>()});
  info.other_nodes = row.at("other_nodes").get<std::vector<std::string>>();
  if (!row.contains("declared")) return info;
  const json& from = row.at("declared");
  auto declared = std::make_shared<runtime::Declarations>();
  for (const auto& name : from.at("names")) declared->parameters.push_back({name.get<std::string>(), {}, false});
  declared->unknown_parameters = from.at("unknown").get<std::vector<std::string>>();
  declared->services = from.at("services").get<std::vector<std::string>>();
  declared->used_remaps = from.at("used_remaps").get<std::vector<bool>>();
  declared->package = from.at("package").get<std::string>();
  for (const auto& use : from.at("frames"))
    declared->frame_uses.push_back({use.at(0).get<std::string>(), use.at(1).get<std::string>()});
  for (const auto& use : from.at("devices"))
    declared->device_uses.push_back({use.at(0).get<std::string>(), use.at(1).get<std::string>()});
  info.declared = std::move(declared);
  return info;
}

}  // namespace nacelle::isolation
