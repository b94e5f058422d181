// SPDX-License-Identifier: Apache-2.0
// Which driver a section of a parameter file is for, and lists that ROS 2 would refuse.
#include "ros_import/identify.hpp"

#include <algorithm>
#include <cctype>

namespace nacelle::ros_import {
namespace {

bool holds(const std::vector<std::string>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

bool has_a_part_of(std::string_view name, const std::vector<std::string>& parts) {
  return std::ranges::any_of(parts, [&](const auto& part) { return name.find(part) != std::string_view::npos; });
}

/// How much of a section a driver would read.
struct Fit {
  std::size_t known = 0, telling = 0, unknown = 0;
};

Fit fit_of(const Driver& driver, const launch::ParameterSection& section) {
  Fit fit;
  for (const auto& parameter : section.parameters) {
    const Key* const key = find_key(driver, parameter.name);
    if (key == nullptr) {
      if (find_common_key(parameter.name) == nullptr) ++fit.unknown;
    } else if (key->name.front() != '*') {  // a row for anything proves nothing
      ++fit.known;
      if (!holds(table().generic, parameter.name)) ++fit.telling;
    }
  }
  return fit;
}

/// Int and double texts of a list, and whether there is nothing else in it.
struct Numbers {
  std::size_t whole = 0, broken = 0;
  bool only = true;
};

Numbers numbers_of(const YamlNode& list) {
  Numbers numbers;
  for (const YamlNode& item : list.items) {
    if (!item.is_scalar() || item.quoted || !item.tag.empty()) return {0, 0, false};
    const auto value = launch::value_of_scalar(item.text);
    if (std::holds_alternative<std::int64_t>(value)) {
      ++numbers.whole;
    } else if (std::holds_alternative<double>(value)) {
      ++numbers.broken;
    } else {
      return {0, 0, false};
    }
  }
  return numbers;
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string out{text};
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

const Driver* driver_of(const launch::ParameterSection& section, std::string_view node_name) {
  const std::string name = lower_case(node_name);
  const Driver* best = nullptr;
  std::size_t best_score = 0;
  for (const Driver& driver : drivers()) {
    const Fit fit = fit_of(driver, section);
    const bool is_named = has_a_part_of(name, driver.named);
    const bool is_hinted = is_named || has_a_part_of(name, driver.hinted);
    const bool most = fit.known >= fit.unknown;
    if (!is_named && !(most && (is_hinted ? fit.known > 0 : fit.telling > 1))) continue;
    const std::size_t score = 2 * fit.known + (is_named ? 1000 : 0) + (is_hinted ? 5 : 0) + 1;
    if (score <= best_score) continue;
    best = &driver;
    best_score = score;
  }
  return best;
}

bool is_of_every_node(const launch::ParameterSection& section) {
  return std::ranges::all_of(section.parameters,
                             [](const auto& parameter) { return find_common_key(parameter.name) != nullptr; });
}

std::string last_part_of(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  return std::string{dot == std::string_view::npos ? name : name.substr(dot + 1)};
}

void widen_lists(YamlNode& node, std::set<ListPlace>& changed) {
  for (YamlNode& item : node.items) {
    if (item.is_map()) widen_lists(item, changed);  // as deep as the document, which parse_yaml() bounds
    if (!item.is_sequence() || !holds(table().double_lists, last_part_of(item.key))) continue;
    const Numbers numbers = numbers_of(item);
    if (!numbers.only || numbers.whole == 0) continue;
    for (YamlNode& number : item.items) {
      const auto value = launch::value_of_scalar(number.text);
      if (const auto* const whole = std::get_if<std::int64_t>(&value))
        number.text = launch::to_text(ParameterValue{static_cast<double>(*whole)});
    }
    changed.emplace(item.key_line, last_part_of(item.key));
  }
}

}  // namespace nacelle::ros_import
