// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "builder.hpp"
#include "nacelle/qos/text.hpp"
#include "shown.hpp"
#include "substitution.hpp"

namespace nacelle::launch {
namespace {

std::optional<double> as_number(std::string_view text) {
  const ParameterValue value = value_of_scalar(text);
  if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
  if (const auto* d = std::get_if<double>(&value)) return *d;
  return std::nullopt;
}

bool equal_values(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const auto left = parse_condition(a);
  const auto right = parse_condition(b);
  if (left && right && !as_number(a) && !as_number(b)) return *left == *right;
  const auto x = as_number(a);
  const auto y = as_number(b);
  return x && y && *x == *y;
}

}  // namespace

std::optional<bool> parse_condition(std::string_view text) {
  for (const auto word : {"true", "True", "TRUE", "1"}) {
    if (text == word) return true;
  }
  for (const auto word : {"false", "False", "FALSE", "0"}) {
    if (text == word) return false;
  }
  return std::nullopt;
}

std::optional<std::string> Builder::evaluate(const RawText& raw, Scope& scope) {
  auto value = substitute(raw.text, [&](const std::string& name, const std::vector<std::string>& arguments) {
    return look_up(name, arguments, scope);
  });
  if (value) {
    evaluated_bytes_ += value->size();
    if (evaluated_bytes_ <= kMaxEvaluatedBytes) return std::move(*value);
    if (evaluated_bytes_ - value->size() <= kMaxEvaluatedBytes)
      report(at(raw.line), LaunchFault::TooMuch, "the substituted texts are longer than 2 MiB together");
    return std::nullopt;
  }
  // The findings of check_template() were reported when the file was read.
  if (check_template(raw.text)) report(at(raw.line), value.error());
  return std::nullopt;
}

std::optional<std::string> Builder::text(const Element& element, std::string_view attribute, Scope& scope) {
  const Attribute* found = element.find(attribute);
  if (found == nullptr || found->is_list || found->values.empty()) return std::nullopt;
  return evaluate(found->values.front(), scope);
}

Result<std::string, Problem> Builder::look_up(const std::string& name, const std::vector<std::string>& arguments,
                                              Scope& scope) {
  const auto as_bool = [&](const std::string& text) -> Result<bool, Problem> {
    if (const auto value = parse_condition(text)) return *value;
    return err(
        Problem{"", "$(" + name + ") needs true or false, not '" + shown(text) + "'", "", LaunchFault::WrongValue});
  };
  const auto text_of = [](bool value) { return std::string(value ? "true" : "false"); };

  if (name == "var") {
    const auto found = scope.variables.find(arguments[0]);
    if (found == scope.variables.end()) {
      std::vector<std::string> names;
      for (const auto& [known, value] : scope.variables) names.push_back(known);
      return err(Problem{"", "no argument or variable has the name '" + shown(arguments[0]) + "'",
                         suggestion(shown(arguments[0]), names), LaunchFault::UnknownName});
    }
    if (!found->second) return err(Problem{});
    return *found->second;
  }
  if (name == "env") {
    const auto changed = scope.environment.find(arguments[0]);
    const auto value = changed != scope.environment.end() ? changed->second
                       : environment_.getenv              ? environment_.getenv(arguments[0])
                                                          : std::nullopt;
    if (value) return *value;
    if (arguments.size() == 2) return arguments[1];
    return err(Problem{"", "the environment variable '" + shown(arguments[0]) + "' is not set",
                       "set it, or write a default: $(env " + shown(arguments[0]) + " default)",
                       LaunchFault::UnknownName});
  }
  if (name == "find-pkg-share") {
    if (environment_.find_package_share) {
      if (auto share = environment_.find_package_share(arguments[0])) return *share;
    }
    const std::string near = nearest_name(arguments[0], environment_.packages);
    return err(Problem{"", "no package has the name '" + shown(arguments[0]) + "'",
                       near.empty() ? "install it, or add the prefix that holds share/" + shown(arguments[0]) +
                                          " to NACELLE_PREFIX_PATH"
                                    : "did you mean '" + near + "'?",
                       LaunchFault::UnknownName});
  }
  if (name == "dirname")
    return (std::filesystem::path(environment_.working_directory) / beside_file(".")).lexically_normal().string();
  if (name == "filename") return files_.back().path;
  if (name == "anon") return arguments[0] + "_" + environment_.anonymous_suffix;
  if (name == "equals") return text_of(equal_values(arguments[0], arguments[1]));
  if (name == "not-equals") return text_of(!equal_values(arguments[0], arguments[1]));
  bool all = true;
  bool any = false;
  for (const auto& argument : arguments) {
    const auto value = as_bool(argument);
    if (!value) return err(value.error());
    all = all && *value;
    any = any || *value;
  }
  return text_of(name == "not" ? !any : name == "and" ? all : any);
}

std::optional<bool> Builder::known_flag(const Element& element, std::string_view attribute, Scope& scope) {
  const auto value = text(element, attribute, scope);
  if (!value) return std::nullopt;
  const auto truth = parse_condition(*value);
  if (!truth) {
    report(at(element.find(attribute)->line), LaunchFault::WrongValue,
           "'" + std::string(attribute) + "' must be true or false, not '" + shown(*value) + "'");
  }
  return truth;
}

bool Builder::flag(const Element& element, std::string_view attribute, bool otherwise, Scope& scope) {
  return known_flag(element, attribute, scope).value_or(otherwise);
}

bool Builder::condition_holds(const Element& element, Scope& scope) {
  // An action whose condition cannot be told is left out: its fault was reported, what it does would add noise.
  for (const auto& [attribute, wanted] : {std::pair{"if", true}, std::pair{"unless", false}}) {
    if (element.find(attribute) == nullptr) continue;
    const auto value = known_flag(element, attribute, scope);
    if (value == wanted) continue;
    // Nor is what a variable would be known then, and its use is no second fault.
    if (!value && (element.name == "let" || element.name == "arg")) {
      if (const auto variable = text(element, "name", scope)) scope.variables[*variable] = std::nullopt;
    }
    return false;
  }
  return true;
}

std::optional<Duration> Builder::duration(const Element& element, std::string_view attribute, Scope& scope) {
  const auto value = text(element, attribute, scope);
  if (!value) return std::nullopt;
  // launch's own durations are seconds without a unit.
  if (const auto number = as_number(*value); number && *number >= 0 && *number < 1e9) return from_seconds(*number);
  auto parsed = parse_duration(*value);
  if (parsed) return *parsed;
  report(at(element.find(attribute)->line), parsed.error());
  return std::nullopt;
}

std::optional<std::uint64_t> Builder::count(const Element& element, std::string_view attribute, std::uint64_t most,
                                            Scope& scope) {
  const auto value = text(element, attribute, scope);
  if (!value) return std::nullopt;
  std::uint64_t number = 0;
  const auto [end, fault] = std::from_chars(value->data(), value->data() + value->size(), number);
  if (fault == std::errc{} && end == value->data() + value->size() && number <= most) return number;
  report(at(element.find(attribute)->line), LaunchFault::WrongValue,
         "'" + std::string(attribute) + "' must be a whole number from 0 to " + std::to_string(most) + ", not '" +
             shown(*value) + "'");
  return std::nullopt;
}

std::optional<std::size_t> Builder::word(const Element& element, std::string_view attribute,
                                         const std::vector<std::string>& words, Scope& scope) {
  const auto value = text(element, attribute, scope);
  if (!value) return std::nullopt;
  const auto found = std::find(words.begin(), words.end(), *value);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  report(at(element.find(attribute)->line), LaunchFault::WrongValue,
         "'" + std::string(attribute) + "' cannot be '" + shown(*value) + "'", suggestion(shown(*value), words));
  return std::nullopt;
}

std::string Builder::beside_file(const std::string& path) const {
  const std::filesystem::path named(path);
  if (named.is_absolute()) return named.lexically_normal().string();
  const auto folder = std::filesystem::path(files_.back().path).parent_path();
  auto joined = (folder / named).lexically_normal().string();
  while (joined.size() > 1 && joined.back() == '/') joined.pop_back();
  return joined.empty() ? "." : joined;
}

std::optional<std::string> Builder::read_file(const std::string& path, const char* kind, const Place& where) {
  if (!environment_.read_file) return std::nullopt;
  auto text = environment_.read_file(path);
  if (text) return std::move(text).value();
  std::string what = std::string("the ") + kind + " '" + path + "' " + text.error().what;
  // A relative path is one from the working directory, which a reader of the message may not know.
  const auto tried = (std::filesystem::path(environment_.working_directory) / path).lexically_normal().string();
  if (tried != path) what += " (tried " + tried + ")";
  report(where, LaunchFault::Unreadable, std::move(what), text.error().way_out);
  return std::nullopt;
}

std::vector<std::string> Builder::words_of(const Element& element, std::string_view attribute, Scope& scope) {
  std::vector<std::string> words;
  const Attribute* found = element.find(attribute);
  if (found == nullptr) return words;
  for (const auto& raw : found->values) {
    if (found->is_list) {
      if (auto value = evaluate(raw, scope)) words.push_back(std::move(*value));
      continue;
    }
    const auto templates = split_words(raw.text);
    if (!templates) {
      report(at(raw.line), templates.error());
      continue;
    }
    for (const auto& one : *templates) {
      if (auto value = evaluate({one, true, raw.line}, scope)) words.push_back(std::move(*value));
    }
  }
  return words;
}

}  // namespace nacelle::launch
