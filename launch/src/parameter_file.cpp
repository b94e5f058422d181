// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/parameter_file.hpp"

#include <algorithm>
#include <cstddef>
#include <map>

#include "nacelle/launch/launch_fault.hpp"

namespace nacelle::launch {
namespace {

constexpr std::string_view kMarker = "ros__parameters";
// Far above any robot's needs, and low enough that a hostile file costs no more than a large honest one.
constexpr std::size_t kMaxSections = 1000;
constexpr std::size_t kMaxParameters = 2000;
constexpr std::size_t kMaxNameBytes = 512;
constexpr std::size_t kMaxProblems = 100;

std::vector<std::string_view> parts_of(std::string_view name) {
  std::vector<std::string_view> parts;
  while (!name.empty()) {
    if (name.front() == '/') {
      name.remove_prefix(1);
      continue;
    }
    const auto end = std::min(name.find('/'), name.size());
    parts.push_back(name.substr(0, end));
    name.remove_prefix(end);
  }
  return parts;
}

bool is_word(std::string_view part) {
  return std::all_of(part.begin(), part.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

/// Whether the marker, or something that is meant to be it, stands anywhere.
bool has_marker(const YamlNode& node) {
  return std::any_of(node.items.begin(), node.items.end(), [](const YamlNode& item) {
    return item.key == kMarker || !nearest_name(item.key, {std::string(kMarker)}).empty() || has_marker(item);
  });
}

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {}

  void read(const YamlNode& root) {
    if (root.is_null()) return;
    if (!root.is_map())
      return report(root.line, LaunchFault::Form, std::string("expected a map of nodes, found ") + root.kind_text());
    refuse_repeated(root);
    for (const YamlNode& node : root.items) read_node("", node);
  }
  std::vector<ParameterSection> sections;
  std::vector<Problem> problems;

 private:
  void report(int line, LaunchFault fault, std::string what, std::string way_out = {}) {
    if (problems.size() >= kMaxProblems) return;
    problems.push_back({Place(file_, line), std::move(what), std::move(way_out), fault});
  }

  void refuse_repeated(const YamlNode& map) {
    std::map<std::string_view, int> first;
    for (const YamlNode& item : map.items) {
      const auto [known, is_new] = first.emplace(item.key, item.key_line);
      if (!is_new)
        report(item.key_line, LaunchFault::Twice,
               "the key '" + item.key + "' stands here a second time; the first is at line " +
                   std::to_string(known->second),
               "leave one of them out");
    }
  }

  // A key above ros__parameters; the recursion is as deep as the document, which parse_yaml() bounds.
  void read_node(const std::string& above, const YamlNode& node) {
    if (node.key == kMarker) {
      if (above.empty())
        return report(node.key_line, LaunchFault::Misplaced, "'ros__parameters' stands below no node",
                      "write '/**:' above it");
      return read_section(above, node);
    }
    if (!above.empty() && !nearest_name(node.key, {std::string(kMarker)}).empty())
      return report(node.key_line, LaunchFault::WrongValue, "'" + node.key + "' is not part of a node's name",
                    "did you mean 'ros__parameters'?");
    std::string pattern = above;
    for (const auto part : parts_of(node.key)) {
      if (part != "*" && part != "**" && !is_word(part)) {
        return report(node.key_line, LaunchFault::WrongValue, "'" + node.key + "' is not the name of a node",
                      "use letters, digits, '_', '/', and the wildcards * and **");
      }
      pattern += "/" + std::string(part);
    }
    if (pattern.size() > kMaxNameBytes)
      return report(node.key_line, LaunchFault::TooMuch,
                    "the node's name is longer than " + std::to_string(kMaxNameBytes) + " bytes");
    if (pattern == above)
      return report(node.key_line, LaunchFault::WrongValue, "'" + node.key + "' is not the name of a node");
    if (!node.is_map()) {
      // The usual slip is a forgotten ros__parameters, so that a parameter stands where a node is expected.
      return report(node.key_line, LaunchFault::Form,
                    "'" + node.key + "' is a node or namespace and needs a map, not " + node.kind_text(),
                    "parameters stand below 'ros__parameters'");
    }
    refuse_repeated(node);
    for (const YamlNode& below : node.items) read_node(pattern, below);
  }

  void read_section(const std::string& pattern, const YamlNode& node) {
    auto section = std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return s.pattern == pattern; });
    if (section == sections.end()) {
      if (sections.size() >= kMaxSections)
        return report(node.key_line, LaunchFault::TooMuch,
                      "more than " + std::to_string(kMaxSections) + " nodes in one file");
      sections.push_back({pattern, {file_, node.key_line}, {}});
      section = sections.end() - 1;
    }
    if (node.is_null()) return;
    if (!node.is_map())
      return report(node.line, LaunchFault::Form,
                    std::string("'ros__parameters' needs a map of parameters, not ") + node.kind_text());
    refuse_repeated(node);
    for (const YamlNode& parameter : node.items) read_parameter("", parameter, section->parameters);
  }

  void read_parameter(const std::string& above, const YamlNode& node, std::vector<Parameter>& into) {
    const std::string name = above.empty() ? node.key : above + "." + node.key;
    if (name.size() > kMaxNameBytes)
      return report(node.key_line, LaunchFault::TooMuch,
                    "the parameter's name is longer than " + std::to_string(kMaxNameBytes) + " bytes");
    if (auto ok = validate_parameter_name(node.key); !ok)
      return report(node.key_line, LaunchFault::WrongValue, ok.error().what);
    if (node.is_null())
      return report(node.key_line, LaunchFault::MissingKey, "the parameter '" + name + "' has no value",
                    "write '' for an empty text");
    if (node.is_map()) {
      refuse_repeated(node);
      for (const YamlNode& below : node.items) read_parameter(name, below, into);
      return;
    }
    if (++parameters_ > kMaxParameters)
      return report(node.key_line, LaunchFault::TooMuch,
                    "more than " + std::to_string(kMaxParameters) + " parameters in one file");
    auto value = value_of_node(node);
    if (!value)
      return report(node.line, LaunchFault::WrongValue, "the parameter '" + name + "': " + value.error().what,
                    value.error().way_out);
    // Not assign(): the section must remember that a later, empty list takes an earlier value back.
    const auto same = std::find_if(into.begin(), into.end(), [&](const Parameter& p) { return p.name == name; });
    Parameter parameter{name, std::move(*value), {file_, node.key_line}};
    if (same != into.end()) {
      *same = std::move(parameter);
    } else {
      into.push_back(std::move(parameter));
    }
  }

  const std::string& file_;
  std::size_t parameters_ = 0;
};

}  // namespace

void assign(std::vector<Parameter>& parameters, Parameter parameter) {
  const auto same =
      std::find_if(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.name == parameter.name; });
  const bool unset = std::holds_alternative<std::monostate>(parameter.value);
  if (same == parameters.end()) {
    if (!unset) parameters.push_back(std::move(parameter));
  } else if (unset) {
    parameters.erase(same);
  } else {
    *same = std::move(parameter);
  }
}

bool matches_node(std::string_view pattern, std::string_view node_full_name) {
  const auto wanted = parts_of(pattern);
  const auto parts = parts_of(node_full_name);
  // reach[i]: the pattern so far can end before part i. No backtracking, so a hostile pattern costs only its length.
  std::vector<bool> reach(parts.size() + 1, false);
  reach[0] = true;
  for (const auto want : wanted) {
    std::vector<bool> next(parts.size() + 1, false);
    if (want == "**") {
      bool open = false;
      for (std::size_t i = 0; i <= parts.size(); ++i) next[i] = open = open || reach[i];
    } else {
      for (std::size_t i = 0; i < parts.size(); ++i) next[i + 1] = reach[i] && (want == "*" || want == parts[i]);
    }
    reach = std::move(next);
  }
  return reach[parts.size()];
}

std::vector<Parameter> ParameterFile::parameters_for(std::string_view node_full_name) const {
  std::vector<Parameter> all;
  for (const auto& section : sections_) {
    if (!matches_node(section.pattern, node_full_name)) continue;
    for (const auto& parameter : section.parameters) assign(all, parameter);
  }
  return all;
}

Result<ParameterFile, std::vector<Problem>> read_parameter_tree(const YamlNode& root, const std::string& file_name) {
  Reader reader(file_name);
  reader.read(root);
  // One word about the whole file instead of one for each of its lines.
  if (!reader.problems.empty() && root.is_map() && !root.items.empty() && !has_marker(root)) {
    return err(std::vector<Problem>{
        {Place(file_name, root.items.front().key_line),
         "the file has no 'ros__parameters': it is of ROS 1's form, or no parameter file",
         "write '<node>:' and below it 'ros__parameters:' above the values, or '/**:' for every node",
         LaunchFault::MissingKey}});
  }
  if (!reader.problems.empty()) return err(std::move(reader.problems));
  return ParameterFile(std::move(reader.sections));
}

Result<ParameterFile, std::vector<Problem>> parse_parameter_file(std::string_view text, const std::string& file_name) {
  const auto root = parse_yaml(text, file_name);
  if (!root) return err(std::vector<Problem>{coded(root.error(), LaunchFault::Form)});
  return read_parameter_tree(*root, file_name);
}

}  // namespace nacelle::launch
