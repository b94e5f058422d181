// SPDX-License-Identifier: Apache-2.0
#include "ask/filters.hpp"

#include <charconv>
#include <string_view>
#include <utility>
#include <vector>

namespace nacelle::ask {
namespace {

using nlohmann::json;

constexpr const char* kType = "diagnostic_msgs/srv/SelfTest";
constexpr std::string_view kService = "/status", kRejected = "rejected_";

template <typename T>
T number(const std::string& text) {
  T value{};
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::string text_at(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

json& axis_of(json& axes, const std::string& name) {
  for (json& axis : axes) {
    if (axis["name"] == name) return axis;
  }
  axes.push_back({{"name", name}, {"nis", 0.0}, {"noise", 0.0}, {"offset", 0.0}, {"scale", 1.0}});
  return axes.back();
}

json input_of(const json& status) {
  const std::string name = text_at(status, "name");
  const auto colon = name.find(": ");
  json input{{"name", colon == std::string::npos ? name : name.substr(colon + 2)},
             {"rate_hz", 0.0},
             {"delay_s", 0.0},
             {"rejected", json::object()},
             {"axes", json::array()},
             {"sentence", ""}};
  for (const char* const key : {"received", "fused", "late", "waiting", "lost"}) input[key] = 0U;
  for (const json& pair : status.value("values", json::array())) {
    const std::string key = text_at(pair, "key"), value = text_at(pair, "value");
    const auto space = key.find(' ');
    const std::string word = key.substr(0, space);
    if (space != std::string::npos) {
      if (word == "nis" || word == "noise" || word == "offset" || word == "scale")
        axis_of(input["axes"], key.substr(space + 1))[word] = number<double>(value);
    } else if (key.starts_with(kRejected)) {
      if (const auto count = number<std::uint64_t>(value); count != 0)
        input["rejected"][key.substr(kRejected.size())] = count;
    } else if (key == "rate") {
      input["rate_hz"] = number<double>(value);
    } else if (key == "delay") {
      input["delay_s"] = number<double>(value);
    } else if (key == "sentence") {
      input["sentence"] = value;
    } else if (input.contains(key) && input[key].is_number_unsigned()) {
      input[key] = number<std::uint64_t>(value);
    }
  }
  return input;
}

}  // namespace

json filter_of(const std::string& node, const json& response) {
  json inputs = json::array();
  for (const json& status : response.value("status", json::array())) inputs.push_back(input_of(status));
  const auto passed = response.find("passed");
  const bool initialised = passed != response.end() && passed->is_number() && passed->get<double>() != 0.0;
  return {{"node", node}, {"initialised", initialised}, {"inputs", std::move(inputs)}};
}

Result<json, Problem> list_filters(Nodes& nodes, const std::string& filter) {
  std::string wanted;
  if (!filter.empty()) {
    auto found = nodes.find(filter);
    if (!found) return err(found.error());
    wanted = std::move(found).value();
  }
  const auto graph = nodes.graph();
  if (!graph) return err(graph.error());
  std::vector<std::string> found;
  for (const json& row : graph.value()["services"]) {
    if (!row["server"].get<bool>() || row["type"] != kType) continue;
    const std::string node = row["node"];
    if (row["name"] == node + std::string{kService} && (wanted.empty() || wanted == node)) found.push_back(node);
  }
  if (found.empty()) {
    return err(
        Problem{wanted.empty() ? Place{"ekf"} : Place{wanted},
                wanted.empty() ? "no node is an EKF" : "is no EKF: it does not offer " + wanted + std::string{kService},
                "nacelle node list shows the nodes; the filter is nacelle::ekf::EkfComponent"});
  }
  json filters = json::array();
  for (const std::string& node : found) {
    const auto answer = nodes.call(node + std::string{kService}, kType, json::object());
    if (!answer) return err(answer.error());
    filters.push_back(filter_of(node, answer.value()));
  }
  return json{{"filters", std::move(filters)}};
}

}  // namespace nacelle::ask
