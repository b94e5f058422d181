// SPDX-License-Identifier: Apache-2.0
#include "ros_import/ros_import.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "nacelle/base/names.hpp"
#include "ros_import/drivers.hpp"
#include "ros_import/identify.hpp"

namespace nacelle::ros_import {
namespace {

using launch::Parameter;
using launch::ParameterSection;

// Recursion of patterns and distances of names cost more for longer ones; no parameter has such a name.
constexpr std::size_t kLongestName = 200;

/// "/robot1/ekf_filter_node" is "/robot1/" and "ekf_filter_node".
std::pair<std::string, std::string> split_name(const std::string& pattern) {
  const std::size_t slash = pattern.rfind('/');
  if (slash == std::string::npos) return {"", pattern};
  std::string prefix = pattern.substr(0, slash + 1);
  // A wildcard, or what no namespace may be called, is no place to put a node.
  if (prefix == "/" || !validate_namespace(prefix.substr(0, slash))) prefix.clear();
  return {prefix, pattern.substr(slash + 1)};
}

class Translator {
 public:
  Translator(const Driver& driver, const ParameterSection& section, Imported& into)
      : driver_(driver), section_(section), into_(into), prefix_(split_name(section.pattern).first) {
    // The base is made of several sections; of filters, cameras and LiDARs each one is a node.
    source_ = driver.shared ? "base" : section.where.text();
    own_node_ = free_name();
  }

  void run() {
    for (const Parameter& parameter : section_.parameters) translate(parameter);
    write_joined();
    for (const Key& key : driver_.keys) add_absent(key);
  }

 private:
  void note(Fate fate, const Parameter& parameter, std::string text) {
    into_.notes.push_back({fate, parameter.where.text(), section_.pattern, parameter.name, std::move(text)});
  }
  [[nodiscard]] bool is_free(const std::string& name) const {
    return std::ranges::none_of(
        into_.nodes, [&](const NodeSection& known) { return known.name == prefix_ + name && known.source != source_; });
  }
  /// Nacelle's name for the first such node; its own for a second one, which needs a component of that name.
  [[nodiscard]] std::string free_name() const {
    std::string name = driver_.node;
    if (name.empty() || is_free(name)) return name;
    std::string own = split_name(section_.pattern).second;
    if (validate_node_name(own) && is_free(own)) return own;
    for (int number = 2;; ++number) {
      if (is_free(name + "_" + std::to_string(number))) return name + "_" + std::to_string(number);
    }
  }
  NodeSection& node(const std::string& name) {
    const std::string full = prefix_ + name;
    for (auto& known : into_.nodes) {
      if (known.name == full) return known;
    }
    return into_.nodes.emplace_back(NodeSection{full, source_, {}});
  }
  void put(const std::string& to_node, Line line) {
    auto& lines = node(to_node).lines;
    const auto known =
        std::ranges::find_if(lines, [&](const Line& other) { return other.name == line.name && other.doubt.empty(); });
    if (known != lines.end() && line.doubt.empty()) {
      *known = std::move(line);  // as in ROS: the later one wins
    } else {
      lines.push_back(std::move(line));
    }
  }
  [[nodiscard]] std::vector<std::string> nodes_of(const Key& key) const {
    if (!key.nodes.empty() || own_node_.empty()) return key.nodes;
    return {own_node_};
  }

  void translate(const Parameter& parameter) {
    const Key* key = find_key(driver_, parameter.name);
    if (key == nullptr) key = find_common_key(parameter.name);
    if (key == nullptr && is_control(parameter)) {
      put(own_node_, {parameter.name, parameter.value, ""});
      return note(Fate::Kept, parameter,
                  fmt::format("{}{}.{}: {} ({})", prefix_, own_node_, parameter.name, launch::to_text(parameter.value),
                              driver_.controls));
    }
    if (key == nullptr) return unknown(parameter);
    if (const std::string input = input_not_given(*key, parameter.name); !input.empty())
      return note(Fate::Dropped, parameter, fmt::format("belongs to {}, which the file does not give", input));
    if (key->fate == Fate::Dropped) return note(Fate::Dropped, parameter, key->text);
    const bool is_doubt = key->fate == Fate::Doubted && key->nodes.empty();
    const ParameterValue none, no_text{std::string{}};
    if ((key->usual != none && parameter.value == key->usual) || (is_doubt && parameter.value == no_text)) {
      return note(Fate::Dropped, parameter,
                  key->usual_text.empty() ? "at its default, which is what Nacelle does" : key->usual_text);
    }
    if (is_doubt) return note(Fate::Doubted, parameter, key->text);
    if (parameter.value == none) return note(Fate::Dropped, parameter, "has no value");
    Line line{name_in_nacelle(*key, parameter.name), parameter.value, ""};
    if (!change_form(*key, parameter, line)) return;
    std::vector<std::string> targets = nodes_of(*key);
    if (targets.empty()) return note(Fate::Dropped, parameter, "the node that it is for has no counterpart");
    std::string said;
    for (const auto& target : targets) {
      put(target, line);
      said += (said.empty() ? "" : " and ") + prefix_ + target + "." + line.name;
    }
    said += ": " + launch::to_text(line.value);
    if (!key->text.empty()) said += fmt::format(" ({})", key->text);
    const Fate fate = key->fate == Fate::Doubted ? Fate::Doubted
                      : key->fate == Fate::Kept && line.name == parameter.name && line.value == parameter.value
                          ? Fate::Kept
                          : Fate::Translated;
    note(fate, parameter, std::move(said));
  }

  /// Such a driver makes a parameter of each control of its device.
  [[nodiscard]] bool is_control(const Parameter& parameter) const {
    if (driver_.controls.empty() || parameter.name.size() > kLongestName) return false;
    const bool is_number =
        std::get_if<std::int64_t>(&parameter.value) != nullptr || std::get_if<bool>(&parameter.value) != nullptr;
    return is_number && nearest_name(parameter.name, names_near(parameter.name)).empty();
  }

  /// robot_localization reads imu0_config where imu0 is given only: "imu0"; empty for any other key.
  [[nodiscard]] std::string input_not_given(const Key& key, const std::string& name) const {
    const std::size_t hash = key.name.find('#');
    if (hash == std::string::npos || hash + 1 == key.name.size()) return {};
    std::string input = name.substr(0, name.find_first_not_of("0123456789", hash));
    const bool given = std::ranges::any_of(section_.parameters, [&](const auto& other) { return other.name == input; });
    return given ? std::string{} : input;
  }

  /// The driver's keys as they would be written here: odom# with the number of the misspelt key.
  [[nodiscard]] std::vector<std::string> names_near(const std::string& misspelt) const {
    std::vector<std::string> names;
    for (const Key& key : driver_.keys) {
      if (key.name.find('*') != std::string_view::npos || key.fate == Fate::Dropped) continue;
      std::string name = key.name;
      const std::size_t digit = misspelt.find_first_of("0123456789");
      if (const std::size_t hash = name.find('#'); hash != std::string::npos)
        name.replace(hash, 1, 1, digit == std::string::npos ? '0' : misspelt[digit]);
      names.push_back(std::move(name));
    }
    return names;
  }

  void unknown(const Parameter& parameter) {
    const std::string near =
        parameter.name.size() > kLongestName ? std::string{} : nearest_name(parameter.name, names_near(parameter.name));
    if (near.empty())
      return note(Fate::Doubted, parameter,
                  fmt::format("Nacelle knows no such key of {}: not translated", driver_.name));
    note(Fate::Doubted, parameter,
         fmt::format("{} has no such key and ignores it; did you mean '{}'?", driver_.name, near));
    const Key* const key = find_key(driver_, near);
    if (key == nullptr || (key->fate == Fate::Doubted && key->nodes.empty())) return;
    for (const auto& target : nodes_of(*key))
      put(target, {name_in_nacelle(*key, near), parameter.value, fmt::format("'{}' in the file", parameter.name)});
  }

  static std::string name_in_nacelle(const Key& key, const std::string& name) {
    if (key.to.empty()) return name;
    std::string to = key.to;
    const std::size_t digit = name.find_first_of("0123456789");
    if (const std::size_t hash = to.find('#'); hash != std::string::npos && digit != std::string::npos) {
      const std::size_t end = std::min(name.find_first_not_of("0123456789", digit), name.size());
      to.replace(hash, 1, name.substr(digit, end - digit));
    }
    return to;
  }

  /// Brings the value into Nacelle's form. False: a note says why there is nothing to write.
  bool change_form(const Key& key, const Parameter& parameter, Line& line) {
    const ParameterValue& value = parameter.value;
    const auto* const word = std::get_if<std::string>(&value);
    const std::optional<double> number = number_of(value);
    const auto doubt = [&] {
      note(Fate::Doubted, parameter, key.otherwise);
      return false;
    };
    if (key.joined != ParameterValue{}) {
      const auto* const whole = std::get_if<std::int64_t>(&value);
      if (whole == nullptr) return doubt();
      joined_[key.to][key.name] = *whole;
      note(Fate::Translated, parameter, key.text);
      return false;
    }
    if (key.form == "list" && word != nullptr) line.value = std::vector<std::string>{*word};
    if (key.form == "period") {
      if (!number || !(*number >= 0.1 && *number <= 1000.0)) return doubt();
      // 29.97 Hz is 1000/29970 s.
      const bool is_whole = std::abs(*number - std::round(*number)) < 1e-6;
      line.value = is_whole ? std::vector<std::int64_t>{1, std::llround(*number)}
                            : std::vector<std::int64_t>{1000, std::llround(*number * 1000)};
    }
    if (!key.values.empty()) {
      const auto found = word == nullptr ? key.values.end() : key.values.find(key.any_case ? lower_case(*word) : *word);
      if (found == key.values.end()) return doubt();
      line.value = found->second;
      if (const auto* const both = std::get_if<std::vector<std::string>>(&found->second);
          both != nullptr && !key.also.empty()) {
        line.value = both->front();
        put(own_node_, {key.also, both->back(), ""});
      }
    }
    if (const auto most = number_of(key.most); most && number && *number > *most)
      note(Fate::Doubted, parameter, fmt::format("{:g} {}", *number, key.otherwise));
    return true;
  }

  static std::optional<double> number_of(const ParameterValue& value) {
    if (const auto* const whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    if (const auto* const broken = std::get_if<double>(&value)) return *broken;
    return std::nullopt;
  }

  /// Writes the lists whose elements are keys of their own. The driver's defaults stand in for those that are not given.
  void write_joined() {
    for (const auto& [name, given] : joined_) {
      std::vector<std::int64_t> list;
      for (const Key& key : driver_.keys) {
        const auto* const standard = std::get_if<std::int64_t>(&key.joined);
        if (standard == nullptr || key.to != name) continue;
        const auto element = given.find(key.name);
        list.push_back(element == given.end() ? *standard : element->second);
      }
      put(own_node_, {name, std::move(list), ""});
    }
  }

  void add_absent(const Key& key) {
    if (key.absent == ParameterValue{}) return;
    for (const std::string& target : nodes_of(key)) {
      auto& lines = node(target).lines;
      if (std::ranges::any_of(lines, [&](const Line& line) { return line.name == key.name && line.doubt.empty(); }))
        continue;
      lines.push_back({key.name, key.absent, ""});
      into_.notes.push_back(
          {Fate::Added, section_.where.text(), section_.pattern, key.name,
           fmt::format("{}{}.{}: {} ({})", prefix_, target, key.name, launch::to_text(key.absent), key.absent_text)});
    }
  }

  const Driver& driver_;
  const ParameterSection& section_;
  Imported& into_;
  const std::string prefix_;
  std::string source_, own_node_;
  std::map<std::string, std::map<std::string, std::int64_t>> joined_;
};

void note_widened(const ParameterSection& section, const std::set<ListPlace>& changed, Imported& into) {
  for (const Parameter& parameter : section.parameters) {
    if (changed.count({parameter.where.line, last_part_of(parameter.name)}) == 0) continue;
    into.notes.push_back({Fate::Doubted, parameter.where.text(), section.pattern, parameter.name,
                          "holds whole numbers, which are written as 1.0 here: ROS 2 refuses the list as it is"});
  }
}

std::string names_of_drivers() {
  std::vector<std::string> names;
  for (const Driver& driver : drivers()) names.push_back(driver.name);
  return join(names);
}

}  // namespace

const char* to_text(Fate fate) {
  switch (fate) {
    case Fate::Kept: return "kept";
    case Fate::Translated: return "translated";
    case Fate::Dropped: return "dropped";
    case Fate::Doubted: return "doubted";
    case Fate::Added: return "added";
  }
  return "";
}

std::string Note::line() const { return fmt::format("{}: {}: {}.{}: {}", to_text(fate), where, node, key, text); }

std::string Imported::yaml() const {
  std::string out;
  for (const auto& node : nodes) {
    if (node.lines.empty()) continue;
    out += fmt::format("{}{}:\n  ros__parameters:\n", out.empty() ? "" : "\n", node.name);
    const bool has_value = std::ranges::any_of(node.lines, [](const Line& line) { return line.doubt.empty(); });
    if (!has_value) out += "    {}\n";
    for (const auto& line : node.lines) {
      out += line.doubt.empty()
                 ? fmt::format("    {}: {}\n", line.name, launch::to_text(line.value))
                 : fmt::format("    # {}: {}  # {}\n", line.name, launch::to_text(line.value), line.doubt);
    }
  }
  return out;
}

Result<void, std::vector<Problem>> import_file(std::string_view text, const std::string& file_name, Imported& into) {
  auto root = parse_yaml(text, file_name);
  if (!root) return err(std::vector<Problem>{root.error()});
  std::set<ListPlace> widened;
  widen_lists(*root, widened);
  const auto file = launch::read_parameter_tree(*root, file_name);
  if (!file) return err(file.error());
  std::vector<const ParameterSection*> unknown;
  std::size_t translated = 0;
  for (const ParameterSection& section : file.value().sections()) {
    if (const Driver* const driver = driver_of(section, split_name(section.pattern).second)) {
      Translator{*driver, section, into}.run();
      note_widened(section, widened, into);
      ++translated;
    } else if (!is_of_every_node(section)) {
      unknown.push_back(&section);
    }
  }
  if (translated == 0 && !unknown.empty()) {
    std::vector<Problem> problems;
    for (const ParameterSection* const section : unknown)
      problems.push_back(
          {section->where, "the driver of '" + section->pattern + "' is unknown: it is none of " + names_of_drivers(),
           "write the parameters of the Nacelle component yourself; `nacelle params --explain` lists them"});
    return err(std::move(problems));
  }
  for (const ParameterSection* const section : unknown) {
    for (const Parameter& parameter : section->parameters) {
      into.notes.push_back({Fate::Doubted, parameter.where.text(), section->pattern, parameter.name,
                            "the node's driver is unknown: not translated"});
    }
  }
  return {};
}

Result<void, Problem> may_write(const std::string& output, const std::vector<std::string>& inputs) {
  for (const auto& input : inputs) {
    std::error_code none;
    if (input == output || std::filesystem::equivalent(input, output, none))
      return err(Problem{output, "would be written over " + input + ", of which it is made", "give another -o FILE"});
  }
  return {};
}

}  // namespace nacelle::ros_import
