// SPDX-License-Identifier: Apache-2.0
#include "reference/markdown.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::reference {
namespace {

using nlohmann::json;

std::string text_of(const json& row, const char* key) { return row.at(key).get<std::string>(); }

/// A text as it shall be read, also within a table.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '|': out += "\\|"; break;
      case '*': out += "\\*"; break;
      case '<': out += "&lt;"; break;
      case '\n': out += ' '; break;
      default: out += c;
    }
  }
  return out;
}

/// A text as code. Within a table a bar ends the cell even there, unless a backslash is before it.
std::string code(const std::string& text) {
  std::string out = "`";
  for (const char c : text) out += c == '|' ? std::string{"\\|"} : std::string{c};
  return out + "`";
}

std::string row(const std::vector<std::string>& cells) { return "| " + join(cells, " | ") + " |\n"; }

/// A table with its heading; nothing without rows.
template <typename CellsOf>
std::string table(const json& rows, const std::vector<std::string>& headings, const CellsOf& cells_of) {
  if (rows.empty()) return "";
  std::string out = "\n" + row(headings) + row(std::vector<std::string>(headings.size(), "---"));
  for (const json& one : rows) out += row(cells_of(one));
  return out;
}

std::string topics(const json& rows, const char* heading) {
  return table(rows, {heading, "Type", "QoS"}, [](const json& one) {
    return std::vector{code(text_of(one, "name")), code(text_of(one, "type")), text_of(one, "qos_text")};
  });
}

std::string named(const json& rows, const char* heading) {
  return table(rows, {heading, "Type"}, [](const json& one) {
    return std::vector{code(text_of(one, "name")), code(text_of(one, "type"))};
  });
}

std::string transforms(const json& rows) {
  return table(rows, {"Broadcasts the transform", "When"}, [](const json& one) {
    std::vector<std::string> when;
    if (one["if_no_other_node_does"].get<bool>()) when.emplace_back("no other node does");
    if (const std::string parameter = text_of(one, "parameter"); !parameter.empty())
      when.push_back("as " + code(parameter) + " says");
    return std::vector{code(text_of(one, "parent")) + " -> " + code(text_of(one, "child")), join(when)};
  });
}

std::string number(const json& value) {
  return value.is_number_float() ? fmt::format("{:g}", value.get<double>()) : value.dump();
}

std::string range(const json& range) {
  if (range.is_null()) return "";
  std::string words = number(range["from"]) + " to " + number(range["to"]);
  if (range["step"].get<double>() != 0) words += " in steps of " + number(range["step"]);
  return words;
}

std::string parameters(const json& rows) {
  return table(rows, {"Parameter", "Type", "Default", "Range", "Read-only", "Description"}, [](const json& one) {
    std::string description = text_of(one, "description");
    if (const std::string more = text_of(one, "constraints"); !more.empty()) description += " (" + more + ")";
    return std::vector<std::string>{code(text_of(one, "name")),
                                    text_of(one, "type"),
                                    one["default"].is_null() ? "" : code(text_of(one, "default")),
                                    range(one["range"]),
                                    one["read_only"].get<bool>() ? "yes" : "",
                                    escaped(description)};
  });
}

std::string lists(const json& all) {
  return topics(all["publishes"], "Publishes") + topics(all["subscribes"], "Subscribes to") +
         named(all["services"], "Service") + named(all["clients"], "Calls the service") +
         named(all["actions"], "Action") + transforms(all["transforms"]) + parameters(all["parameters"]);
}

/// "`a`, `b`"
std::string codes(const json& texts) {
  std::vector<std::string> all;
  for (const json& text : texts) all.push_back(code(text.get<std::string>()));
  return join(all);
}

}  // namespace

std::string markdown_of(const json& all) {
  std::string out = "## " + text_of(all, "plugin") + "\n\n";
  if (const std::string purpose = text_of(all, "purpose"); !purpose.empty()) out += escaped(purpose) + "\n\n";
  out += fmt::format("Package {}, node {}{}.", code(text_of(all, "package")), code(text_of(all, "node")),
                     all["managed"].get<bool>() ? " with a lifecycle" : "");
  json devices = all["devices"];
  if (all.contains("also")) devices.insert(devices.end(), all["also"]["devices"].begin(), all["also"]["devices"].end());
  const std::string text = text_of(all, "devices_text");
  if (!text.empty() || !devices.empty()) {
    out += " Devices: " + (text.empty() ? "not described" : escaped(text));
    if (!devices.empty()) out += " (parameter " + codes(devices) + ")";
    out += ".";
  }
  out += "\n" + lists(all);
  if (all.contains("also")) {
    const std::string more = lists(all["also"]);
    out += "\nWith " + codes(all["with_parameters"]) +
           (more.empty() ? " it has nothing more.\n" : " it also has:\n" + more);
  }
  return out;
}

}  // namespace nacelle::reference
