// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <filesystem>

#include "builder.hpp"
#include "shown.hpp"

namespace nacelle::launch {
namespace {

// Above any robot's needs; a file that includes two that include two would be far beyond them.
constexpr std::size_t kMaxIncludeDepth = 16;
constexpr std::size_t kMaxFiles = 200;

/// Names nothing, so that `namespace` may stand after it. A group is what is in it.
bool is_prelude(const std::string& action) {
  static constexpr std::array kNames{"let", "log", "set_env", "unset_env", "group"};
  return std::ranges::find(kNames, action) != kNames.end();
}

/// The choice that a value is, or means: "True" and "1" are "true", as in every condition.
std::optional<std::string> choice_of(const std::string& value, const std::vector<std::string>& choices) {
  if (std::ranges::find(choices, value) != choices.end()) return value;
  const auto meant = parse_condition(value);
  if (!meant) return std::nullopt;
  const auto same = std::ranges::find_if(choices, [&](const auto& choice) { return parse_condition(choice) == meant; });
  return same == choices.end() ? std::nullopt : std::optional{*same};
}

}  // namespace

Builder::Builder(const Environment& environment, const std::map<std::string, std::string>& arguments, Wanted wanted)
    : environment_(environment), arguments_(arguments), wanted_(wanted) {}

void Builder::report(const Place& where, LaunchFault fault, std::string what, std::string way_out) {
  problems_.push_back({where, std::move(what), std::move(way_out), fault});
}

void Builder::report(const Place& where, Problem problem) {
  if (problem.what.empty()) return;
  problem.where = where;
  problems_.push_back(coded(std::move(problem), LaunchFault::WrongValue));
}

void Builder::run_top(const std::string& text, const std::string& path) {
  plan_.file = path;
  Scope scope;
  for (const auto& [name, value] : arguments_) scope.variables[name] = value;
  enter_namespace(scope);
  run_file(text, path, scope, std::nullopt);
}

void Builder::run_file(const std::string& text, const std::string& path, Scope& scope,
                       const std::optional<Place>& from) {
  if (++files_read_ > kMaxFiles) {
    return report(from.value_or(Place{path, 0}), LaunchFault::TooMuch,
                  "more than " + std::to_string(kMaxFiles) + " files are included");
  }
  auto root = read_launch_file(text, path);
  if (!root) {
    for (const auto& problem : root.error()) problems_.push_back(coded(problem, LaunchFault::Form));
    return;
  }
  check_schema(*root, path, problems_);
  files_.push_back({path, {}});
  run_actions(*root, scope);
  File done = std::move(files_.back());
  files_.pop_back();
  if (!files_.empty()) files_.back().declared.insert(done.declared.begin(), done.declared.end());
  declared_.insert(done.declared.begin(), done.declared.end());
}

bool Builder::counted(const Element& action) {
  if (++actions_run_ == kMaxActions + 1)
    report(at(action.line), LaunchFault::TooMuch, "more than " + std::to_string(kMaxActions) + " actions and nodes");
  return actions_run_ <= kMaxActions;
}

void Builder::run_actions(const Element& parent, Scope& scope) {
  for (const auto& action : parent.children) run_action(action, scope);
}

void Builder::run_action(const Element& action, Scope& scope) {
  if (!counted(action) || !condition_holds(action, scope)) return;
  const std::string& name = action.name;
  if (name == "arg") return declare_argument(action, scope);
  if (name == "include") return include(action, scope);
  if (name == "namespace") return name_space(action, scope);
  if (!is_prelude(name)) note_named(at(action.line));
  if (name == "group") return group(action, scope);
  if (name == "node" || name == "executable") return program(action, scope);
  if (name == "node_container") return container(action, scope);
  if (name == "load_composable_node") return load_composable(action, scope);
  if (name == "network") return network(action, scope);
  if (name == "look") return look(action, scope);
  if (name == "push_ros_namespace" || name == "push-ros-namespace") {
    scope.namespace_ = node_namespace(action, scope);
  } else if (name == "let") {
    const auto variable = text(action, "name", scope);
    if (variable) scope.variables[*variable] = text(action, "value", scope);
  } else if (name == "set_env") {
    const auto variable = text(action, "name", scope);
    const auto value = text(action, "value", scope);
    if (variable && value) scope.environment[*variable] = *value;
  } else if (name == "unset_env") {
    if (const auto variable = text(action, "name", scope)) scope.environment[*variable] = std::nullopt;
  } else if (name == "log") {
    if (auto message = text(action, "message", scope)) plan_.messages.push_back({std::move(*message), at(action.line)});
  } else if (name == "set_parameter") {
    const auto parameter = text(action, "name", scope);
    if (!parameter) return;
    if (auto ok = validate_parameter_name(*parameter); !ok) return report(at(action.line), ok.error());
    if (auto value = parameter_value(action, scope)) {
      scope.parameters.push_back({{*parameter, std::move(*value), at(action.line)}, nullptr, "", false});
    }
  } else if (name == "set_parameters_from_file") {
    read_parameter_file(action, "filename", false, scope, scope.parameters);
  } else if (name == "set_remap") {
    const auto from = text(action, "from", scope);
    const auto to = text(action, "to", scope);
    if (!from || !to) return;
    const auto rule = make_remap_rule(*from, *to);
    if (!rule) return report(at(action.line), rule.error());
    scope.remaps.push_back(*rule);
    scope.remap_lines.push_back(at(action.line));
    plan_.shared_remaps.push_back({*rule, at(action.line)});
  } else if (name == "set_use_sim_time") {
    if (action.find("value") == nullptr) return;
    scope.parameters.push_back(
        {{"use_sim_time", flag(action, "value", false, scope), at(action.line)}, nullptr, "", false});
  }
}

void Builder::declare_argument(const Element& element, Scope& scope) {
  const auto name = text(element, "name", scope);
  if (!name) return;
  ArgumentPlan argument{*name, std::nullopt, text(element, "description", scope).value_or(""), {}, at(element.line)};
  files_.back().declared.insert(*name);
  for (const auto& child : element.children) {
    if (auto choice = text(child, "value", scope)) argument.choices.push_back(std::move(*choice));
  }
  if (element.find("default") != nullptr) {
    argument.default_value = text(element, "default", scope);
    if (!argument.default_value && scope.variables.count(*name) == 0) scope.variables[*name] = std::nullopt;
  }
  const auto given = scope.variables.find(*name);
  if (given == scope.variables.end() && !argument.default_value) {
    lacks_argument_ = true;
    if (wanted_ == Wanted::Plan) {
      report(argument.where, LaunchFault::MissingKey, "the argument '" + *name + "' has no value and no default",
             "give it: " + *name + ":=...");
    }
    scope.variables[*name] = std::nullopt;
  } else if (given == scope.variables.end()) {
    scope.variables[*name] = *argument.default_value;
  }
  if (auto& value = scope.variables[*name]; value && !argument.choices.empty()) {
    if (auto choice = choice_of(*value, argument.choices)) {
      value = std::move(choice);
    } else {
      report(argument.where, LaunchFault::WrongValue, "the argument '" + *name + "' cannot be '" + shown(*value) + "'",
             "one of " + join(argument.choices));
      value.reset();  // one mistake, one report: what depends on it is left out
    }
  }
  const bool known =
      std::any_of(plan_.arguments.begin(), plan_.arguments.end(), [&](const auto& a) { return a.name == *name; });
  if (!known) plan_.arguments.push_back(std::move(argument));
}

void Builder::include(const Element& element, Scope& scope) {
  const auto named = text(element, "file", scope);
  std::vector<std::pair<std::string, Place>> given;
  for (const auto& child : element.children) {
    const auto name = text(child, "name", scope);
    if (!name) continue;
    scope.variables[*name] = text(child, "value", scope);
    if (child.name == "arg") given.emplace_back(*name, at(child.line));
  }
  if (!named) return;
  const Place where = at(element.line);
  const std::string path = beside_file(*named);
  std::string chain;
  for (const auto& file : files_) {
    chain += file.path + " -> ";
    if (std::filesystem::path(file.path).lexically_normal() != std::filesystem::path(path)) continue;
    chain += path;
    return report(where, LaunchFault::Circle, "the files include each other: " + chain, "take one of the includes out");
  }
  if (files_.size() >= kMaxIncludeDepth)
    return report(where, LaunchFault::TooMuch,
                  "includes are nested more than " + std::to_string(kMaxIncludeDepth) + " deep");
  const auto content = read_file(path, "launch file", where);
  if (!content) return;
  // What the file itself declares decides whether an argument of the include is known.
  std::set<std::string> before;
  std::swap(before, files_.back().declared);
  const std::size_t problems = problems_.size();
  run_file(*content, path, scope, where);
  const auto& declared = files_.back().declared;
  for (const auto& [name, line] : given) {
    // A file that could not be read to its end may declare anything.
    if (declared.count(name) != 0 || (problems_.size() > problems && declared.empty())) continue;
    std::string what = "the file '" + path;
    what.append("' declares no argument '").append(name).append("'");
    report(line, LaunchFault::UnknownName, std::move(what), suggestion(name, {declared.begin(), declared.end()}));
  }
  files_.back().declared.insert(before.begin(), before.end());
}

void Builder::group(const Element& element, Scope& scope) {
  ++groups_;
  if (!flag(element, "scoped", true, scope)) {
    run_actions(element, scope);
  } else {
    Scope inner = flag(element, "forwarding", true, scope) ? scope : outermost_;
    run_actions(element, inner);
  }
  --groups_;
}

void Builder::program(const Element& element, Scope& scope) {
  ProgramPlan made;
  made.where = at(element.line);
  if (element.name == "executable") {
    auto words = words_of(element, "cmd", scope);
    if (words.empty()) {
      if (element.find("cmd") != nullptr) report(made.where, LaunchFault::MissingKey, "'cmd' names no program");
      return;
    }
    made.executable = words.front();
    made.arguments.assign(words.begin() + 1, words.end());
  } else {
    made.package = text(element, "pkg", scope).value_or("");
    const auto executable = text(element, "exec", scope);
    if (!executable) return;
    made.executable = *executable;
  }
  for (auto& word : words_of(element, "args", scope)) made.arguments.push_back(std::move(word));

  std::vector<ParameterSource> parameters = scope.parameters;
  std::vector<RemapRule> remaps = scope.remaps;
  if (element.name == "node") {
    made.name = text(element, "name", scope).value_or("");
    if (auto ok = validate_node_name(made.name); !made.name.empty() && !ok)
      report(at(element.find("name")->line), ok.error());
    // As launch_ros: the namespace is given when the file says anything about it.
    if (element.find("namespace") != nullptr || scope.namespace_ != "/")
      made.namespace_ = node_namespace(element, scope);
    made.ros_arguments = words_of(element, "ros_args", scope);
    read_parameters(element, scope, "", parameters);
    read_remaps(element, scope, remaps);
  } else {
    parameters.clear();
    remaps.clear();
  }
  made.label =
      text(element, "exec_name", scope)
          .value_or(text(element, "name", scope).value_or(std::filesystem::path(made.executable).filename().string()));

  auto& ros = made.ros_arguments;
  const auto add = [&ros](const char* option, std::string value) {
    ros.emplace_back(option);
    ros.push_back(std::move(value));
  };
  if (!made.name.empty()) add("-r", "__node:=" + made.name);
  if (!made.namespace_.empty()) add("-r", "__ns:=" + made.namespace_);
  for (const auto& rule : remaps) add("-r", to_text(rule));
  const std::string full_name = made.name.empty() ? "" : fully_qualified_node_name(made.namespace_, made.name);
  for (const auto& source : parameters) {
    if (source.file != nullptr) note_sections(source, full_name);
    // Its sections are written without the launch's namespace, which the program could not know.
    const bool as_it_is = !plan_.name_space.moves() || full_name.empty();
    if (source.file != nullptr && !source.substituted && as_it_is) {
      add("--params-file", source.path);
    } else {
      for (const auto& p : resolve({source}, full_name)) add("-p", p.name + ":=" + to_text(p.value));
    }
  }

  for (const auto& [name, value] : scope.environment) made.environment.emplace_back(name, value);
  for (const auto& child : element.children) {
    if (child.name != "env") continue;
    const auto name = text(child, "name", scope);
    const auto value = text(child, "value", scope);
    if (name && value) made.environment.emplace_back(*name, *value);
  }
  if (const auto folder = text(element, "cwd", scope)) made.working_directory = beside_file(*folder);
  const std::vector<std::string> outputs{"screen", "log", "both", "own_log", "full"};
  if (const auto output = word(element, "output", outputs, scope)) made.output = outputs[*output];
  made.respawn = flag(element, "respawn", false, scope);
  made.required = flag(element, "required", false, scope);
  made.respawn_delay = duration(element, "respawn_delay", scope);
  made.sigterm_timeout = duration(element, "sigterm_timeout", scope);
  made.sigkill_timeout = duration(element, "sigkill_timeout", scope);
  plan_.programs.push_back(std::move(made));
}

void Builder::container(const Element& element, Scope& scope) {
  if (plan_.container.declared) {
    report(
        at(element.line), LaunchFault::Twice,
        "a second node_container; the first is at " + plan_.container.where.text(),
        "one process holds the whole robot: put these components into the first, or start a second `nacelle launch`");
  } else {
    ContainerPlan& made = plan_.container;
    made.declared = true;
    made.where = at(element.line);
    if (auto name = text(element, "name", scope)) made.name = *name;
    if (auto ok = validate_node_name(made.name); !ok) report(at(element.line), ok.error());
    made.namespace_ = node_namespace(element, scope);
    std::vector<ParameterSource> sources = scope.parameters;
    read_parameters(element, scope, "", sources);
    made.parameters = resolve(sources, fully_qualified_node_name(made.namespace_, made.name));
    std::erase_if(made.parameters, [](const Parameter& given) { return given.name == kFramePrefixParameter; });
  }
  for (const auto& child : element.children) {
    if (child.name == "composable_node") component(child, scope);
  }
}

void Builder::load_composable(const Element& element, Scope& scope) {
  if (auto target = text(element, "target", scope)) targets_.push_back({std::move(*target), at(element.line)});
  for (const auto& child : element.children) {
    if (child.name == "composable_node") component(child, scope);
  }
}

}  // namespace nacelle::launch
