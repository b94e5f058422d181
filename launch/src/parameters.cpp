// SPDX-License-Identifier: Apache-2.0
#include "builder.hpp"
#include "nacelle/qos/yaml_tree.hpp"
#include "substitution.hpp"

namespace nacelle::launch {

void Builder::read_parameters(const Element& element, Scope& scope, const std::string& prefix,
                              std::vector<ParameterSource>& into) {
  for (const auto& child : element.children) {
    if (child.name == "param") read_parameter(child, scope, prefix, into);
  }
}

void Builder::read_parameter(const Element& param, Scope& scope, const std::string& prefix,
                             std::vector<ParameterSource>& into) {
  const bool has_name = param.find("name") != nullptr;
  const bool has_value = param.find("value") != nullptr;
  const bool has_file = param.find("from") != nullptr;
  if (has_file) {
    if (has_name || has_value || !param.children.empty())
      return report(at(param.line), LaunchFault::Misplaced, "a 'param' has either 'from' or 'name', not both");
    if (!prefix.empty())
      return report(at(param.line), LaunchFault::Misplaced, "a nested 'param' cannot have 'from'",
                    "put it beside the outer one");
    return read_parameter_file(param, "from", flag(param, "allow_substs", false, scope), scope, into);
  }
  if (!has_name) return report(at(param.line), LaunchFault::MissingKey, "a 'param' needs 'name' or 'from'");
  if (has_value != param.children.empty())
    return report(at(param.line), LaunchFault::MissingKey, "a 'param' needs either 'value' or nested 'param'");
  const auto name = text(param, "name", scope);
  if (!name) return;
  if (auto ok = validate_parameter_name(*name); !ok) return report(at(param.find("name")->line), ok.error());
  const std::string full = prefix.empty() ? *name : prefix + "." + *name;
  if (!has_value) return read_parameters(param, scope, full, into);
  if (auto value = parameter_value(param, scope))
    into.push_back({{full, std::move(*value), at(param.line)}, nullptr, "", false});
}

std::optional<ParameterValue> Builder::parameter_value(const Element& element, Scope& scope) {
  ForcedType type = ForcedType::None;
  if (element.find("type") != nullptr) {
    const auto word = text(element, "type", scope);
    if (!word) return std::nullopt;
    const auto parsed = parse_forced_type(*word);
    if (!parsed) {
      report(at(element.find("type")->line), parsed.error());
      return std::nullopt;
    }
    type = *parsed;
  }
  const Attribute* attribute = element.find("value");
  if (attribute == nullptr) return std::nullopt;
  YamlNode node;
  node.kind = YamlNode::Kind::Sequence;
  for (const auto& raw : attribute->values) {
    auto value = evaluate(raw, scope);
    if (!value) return std::nullopt;
    YamlNode item;
    item.kind = YamlNode::Kind::Scalar;
    item.text = std::move(*value);
    // Quotes around a substitution are YAML's need, not a wish for text.
    item.quoted = raw.literal && !has_substitution(raw.text);
    node.items.push_back(std::move(item));
  }
  const bool plain = !attribute->is_list && !node.items.front().quoted;
  auto value = attribute->is_list ? value_of_node(node, type)
               : plain            ? value_of_type(node.items.front().text, type)
                                  : value_of_node(node.items.front(), type);
  if (value) return std::move(*value);
  report(at(attribute->line), value.error());
  return std::nullopt;
}

void Builder::read_parameter_file(const Element& element, std::string_view attribute, bool substituted, Scope& scope,
                                  std::vector<ParameterSource>& into) {
  const auto named = text(element, attribute, scope);
  if (!named) return;
  const std::string path = beside_file(*named);
  if (const auto known = parameter_files_.find(path); known != parameter_files_.end() && !substituted) {
    if (known->second != nullptr) into.push_back({{}, known->second, path, false});
    return;
  }
  // Every component names the same file: reported once, where it is named first.
  if (unreadable_.contains(path)) return;
  const auto content = read_file(path, "parameter file", at(element.find(attribute)->line));
  if (!content) {
    unreadable_.insert(path);
    return;
  }
  auto root = parse_yaml(*content, path);
  std::vector<Problem> faults;
  std::shared_ptr<const ParameterFile> file;
  if (!root) {
    faults.push_back(root.error());
  } else {
    if (substituted) substitute_tree(*root, path, scope);
    auto parsed = read_parameter_tree(*root, path);
    if (parsed) {
      file = std::make_shared<const ParameterFile>(std::move(*parsed));
    } else {
      faults = parsed.error();
    }
  }
  for (auto& fault : faults) problems_.push_back(coded(std::move(fault), LaunchFault::Form));
  if (!substituted) parameter_files_[path] = file;
  if (file != nullptr) into.push_back({{}, file, path, substituted});
}

void Builder::substitute_tree(YamlNode& node, const std::string& path, Scope& scope) {
  for (YamlNode& item : node.items) substitute_tree(item, path, scope);
  if (!node.is_scalar() || !has_substitution(node.text)) return;
  auto value = substitute(node.text, [&](const std::string& name, const std::vector<std::string>& arguments) {
    return look_up(name, arguments, scope);
  });
  if (!value) return report({path, node.line}, value.error());
  node.text = std::move(*value);
  node.quoted = false;
}

void Builder::note_sections(const ParameterSource& source, const std::string& full_name) {
  for (const auto& section : source.file->sections()) {
    // A program without a name may be any node.
    const bool used = full_name.empty() || matches_node(section.pattern, full_name) ||
                      matches_node(section.pattern, name_in_files(full_name));
    auto& known = sections_[{source.path, section.pattern}];
    known.first = section.where;
    known.second = known.second || used;
  }
}

std::vector<Parameter> Builder::resolve(const std::vector<ParameterSource>& sources, const std::string& full_name) {
  std::vector<Parameter> all;
  for (const auto& source : sources) {
    if (source.file == nullptr) {
      assign(all, source.parameter);
      continue;
    }
    note_sections(source, full_name);
    // As written for the robot alone, and as written for this robot among others.
    for (const auto& section : source.file->sections()) {
      if (!matches_node(section.pattern, full_name) && !matches_node(section.pattern, name_in_files(full_name)))
        continue;
      for (const auto& parameter : section.parameters) assign(all, parameter);
    }
  }
  return all;
}

void Builder::read_remaps(const Element& element, Scope& scope, std::vector<RemapRule>& into,
                          std::vector<Place>* lines) {
  for (const auto& child : element.children) {
    if (child.name != "remap") continue;
    const auto from = text(child, "from", scope);
    const auto to = text(child, "to", scope);
    if (!from || !to) continue;
    if (auto rule = make_remap_rule(*from, *to)) {
      into.push_back(std::move(*rule));
      if (lines != nullptr) lines->push_back(at(child.line));
    } else {
      report(at(child.line), rule.error());
    }
  }
}

// rcl would rename the node; the rest of the plan (after, qos, parameters) would still mean the old name.
void Builder::check_remaps(const ComponentPlan& component) {
  for (std::size_t i = 0; i < component.remaps.size(); ++i) {
    const RemapRule& rule = component.remaps[i];
    if (rule.kind != RemapKind::NodeName && rule.kind != RemapKind::Namespace) continue;
    if (!rule.node.empty() && rule.node != component.name) continue;
    const bool is_name = rule.kind == RemapKind::NodeName;
    const bool shared = i < component.shared_remaps;
    report(shared ? component.where : component.remap_lines[i], LaunchFault::Misplaced,
           std::string("a remap of ") + (is_name ? "'__node'" : "'__ns'") + " cannot rename a composable_node" +
               (shared ? ": the set_remap is at " + component.remap_lines[i].text() : ""),
           is_name ? "write name: " + rule.to : "write namespace: " + rule.to);
  }
}

std::string Builder::node_namespace(const Element& element, Scope& scope) {
  const auto own = text(element, "namespace", scope);
  std::string full = join_namespaces(scope.namespace_, own.value_or(""));
  if (auto ok = validate_namespace(full); !ok) {
    const Attribute* attribute = element.find("namespace");
    report(at(attribute != nullptr ? attribute->line : element.line), ok.error());
    return "/";
  }
  return full;
}

}  // namespace nacelle::launch
