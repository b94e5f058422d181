// SPDX-License-Identifier: Apache-2.0
#include "record/model/tolerances.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::record {
namespace {

constexpr const char* kForm = "write it as /topic: {field.path: 0.001}, or {field.path: {ignore: true}}";

Problem wrong(const std::string& file, int line, ToleranceFault fault, std::string what, const std::string& value) {
  return {Place{file, line}, std::move(what), kForm, fault, value};
}

bool read_number(const YamlNode& node, double& to) {
  const std::string& text = node.text;
  if (!node.is_scalar() || node.quoted) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(to) && to >= 0.0;
}

Result<Allowance, Problem> allowance_of(const YamlNode& node, const std::string& file) {
  Allowance allowance;
  const auto bad_number = [&](const YamlNode& value) {
    return err(wrong(file, value.line, ToleranceFault::WrongValue,
                     "the tolerance of " + node.key + " is no number of at least 0", value.text));
  };
  if (!node.is_map()) {
    if (!read_number(node, allowance.tolerance)) return bad_number(node);
    return allowance;
  }
  for (const YamlNode& item : node.items) {
    if (item.key == "tolerance") {
      if (!read_number(item, allowance.tolerance)) return bad_number(item);
    } else if (item.key == "ignore") {
      if (!item.is_scalar() || (item.text != "true" && item.text != "false"))
        return err(wrong(file, item.line, ToleranceFault::WrongValue,
                         "'ignore' of " + node.key + " is neither true nor false", item.text));
      allowance.ignore = item.text == "true";
    } else {
      return err(wrong(file, item.key_line, ToleranceFault::WrongShape,
                       "'" + item.key + "' is neither 'tolerance' nor 'ignore'", item.key));
    }
  }
  return allowance;
}

}  // namespace

template <typename Fits>
ToleranceScope ToleranceScope::inside(Fits fits) const {
  ToleranceScope scope;
  scope.depth_ = depth_ + 1;
  scope.allowance_ = allowance_;
  for (const ToleranceRule* rule : open_) {
    if (!fits(rule->steps[depth_])) continue;
    if (rule->steps.size() > scope.depth_)
      scope.open_.push_back(rule);
    else
      scope.allowance_ = rule->allowance;
  }
  return scope;
}

ToleranceScope ToleranceScope::field(std::string_view name) const {
  return inside([&](const PathStep& step) { return step.kind == PathStep::Kind::Field && step.name == name; });
}

ToleranceScope ToleranceScope::element(std::size_t index) const {
  return inside([&](const PathStep& step) {
    return step.kind == PathStep::Kind::EveryElement || (step.kind == PathStep::Kind::Element && step.index == index);
  });
}

bool ToleranceScope::elements_are_alike() const {
  return std::ranges::none_of(
      open_, [&](const ToleranceRule* rule) { return rule->steps[depth_].kind == PathStep::Kind::Element; });
}

Result<Tolerances, Problem> Tolerances::parse(std::string_view yaml, const std::string& file_name) {
  const auto root = parse_yaml(yaml, file_name);
  if (!root) return err(root.error());
  Tolerances made;
  made.file_ = file_name;
  if (root->is_null()) return made;
  if (!root->is_map())
    return err(wrong(file_name, root->line, ToleranceFault::WrongShape,
                     std::string{root->kind_text()} + " is no map of topics", root->text));
  for (const YamlNode& topic : root->items) {
    if (!topic.is_map() || (topic.key != "*" && !topic.key.starts_with('/')))
      return err(wrong(file_name, topic.key_line, ToleranceFault::WrongShape,
                       "'" + topic.key + "' is no topic with a map of fields", topic.key));
    auto& rules = made.rules_[topic.key];
    for (const YamlNode& item : topic.items) {
      auto steps = parse_field_path(item.key);
      if (!steps)
        return err(wrong(file_name, item.key_line, ToleranceFault::WrongPath,
                         "'" + item.key + "' is no path of a field: " + steps.error().what, item.key));
      const auto allowance = allowance_of(item, file_name);
      if (!allowance) return err(allowance.error());
      rules.push_back({item.key, std::move(*steps), *allowance, item.key_line});
    }
  }
  return made;
}

ToleranceScope Tolerances::of_topic(const std::string& topic) const {
  std::vector<const ToleranceRule*> all;
  for (const std::string& key : {std::string{"*"}, topic}) {
    const auto found = rules_.find(key);
    if (found == rules_.end()) continue;
    for (const ToleranceRule& rule : found->second) all.push_back(&rule);
  }
  return ToleranceScope{std::move(all)};
}

Result<void, Problem> Tolerances::check(const std::string& topic, const msgs::MessageType& type) const {
  const auto found = rules_.find(topic);
  if (found == rules_.end()) return {};
  for (const ToleranceRule& rule : found->second) {
    if (const auto checked = check_field_path(type, rule.path); !checked)
      return err(Problem{Place{file_, rule.line}, rule.path + ": " + checked.error().what, checked.error().way_out,
                         ToleranceFault::WrongPath, rule.path});
  }
  return {};
}

}  // namespace nacelle::record
