// SPDX-License-Identifier: Apache-2.0
#include "texts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

namespace nacelle::description {
namespace {

constexpr std::size_t kMaxReads = 1000000;                  // of properties
constexpr std::size_t kLongestText = std::size_t{1} << 20;  // of one attribute or text

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

std::string Texts::argument(const std::string& name) {
  asked_.push_back(name);
  if (const auto given = given_.find(name); given != given_.end()) return given->second;
  if (const auto known = defaults_.find(name); known != defaults_.end()) {
    if (known->second) return *known->second;
    trail_.fail("the argument '" + name + "' has no value", "give it as " + name + ":=value");
  }
  std::vector<std::string> names;
  for (const auto& [key, value] : defaults_) names.push_back(key);
  trail_.fail("there is no argument '" + name + "'", suggestion(name, names));
}

std::string Texts::substitution(const std::string& text) {
  const auto words = words_of(text);
  const std::string name = words.empty() ? std::string{} : words[0];
  const auto needs = [&](std::size_t count) {
    if (words.size() != count + 1)
      trail_.fail(fmt::format("$({}) takes {} word{}, not {}", name, count, count == 1 ? "" : "s",
                              words.empty() ? 0 : words.size() - 1));
  };
  if (name == "arg") {
    needs(1);
    return argument(words[1]);
  }
  if (name == "find" || name == "find-pkg-share") {
    needs(1);
    std::string folder = environment_.find_package ? environment_.find_package(words[1]) : std::string{};
    if (folder.empty())
      trail_.fail("there is no package '" + words[1] + "'",
                  "it is looked for as share/" + words[1] +
                      " below the folders of NACELLE_PREFIX_PATH and AMENT_PREFIX_PATH; $(dirname) "
                      "is the folder of the file itself");
    return folder;
  }
  if (name == "env") {
    needs(1);
    auto value = environment_.variable ? environment_.variable(words[1]) : std::nullopt;
    if (!value)
      trail_.fail("the environment variable '" + words[1] + "' is not set",
                  "or write $(optenv " + words[1] + " default)");
    return *value;
  }
  if (name == "optenv") {
    if (words.size() < 2) trail_.fail("$(optenv) takes a name and a default");
    if (auto value = environment_.variable ? environment_.variable(words[1]) : std::nullopt) return *value;
    const auto rest = text.find(words[1]) + words[1].size();
    return words.size() == 2 ? std::string{} : text.substr(text.find_first_not_of(" \t", rest));
  }
  if (name == "dirname") {
    needs(0);
    const std::string folder = std::filesystem::path(trail_.file()).parent_path().string();
    return folder.empty() ? "." : folder;
  }
  if (name == "cwd") {
    needs(0);
    std::error_code none;
    return std::filesystem::current_path(none).string();
  }
  trail_.fail("unknown substitution $(" + name.substr(0, 60) + ")",
              suggestion(name.substr(0, 60), {"arg", "find", "env", "optenv", "dirname", "cwd"}));
}

/// The end of ${...} or $(...) that begins at `at`; quotes hide what is in them.
std::size_t Texts::end_of(const std::string& text, std::size_t at) const {
  const char open = text[at + 1], close = open == '{' ? '}' : ')';
  int depth = 0;
  char quote = '\0';
  for (std::size_t i = at + 1; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (open == '{' && (c == '\'' || c == '"')) {
      quote = c;
    } else if (c == open) {
      ++depth;
    } else if (c == close && --depth == 0) {
      return i;
    }
  }
  trail_.fail("'" + text.substr(at, 40) + "' lacks its '" + close + "'");
}

Value Texts::evaluate_text(const std::string& text, const Scope& scope) {
  std::string out;
  std::optional<Value> single;
  for (std::size_t i = 0; i < text.size();) {
    if (text.size() - i >= 3 && text[i] == '$' && text[i + 1] == '$' && (text[i + 2] == '{' || text[i + 2] == '(')) {
      const std::size_t end = end_of(text, i + 1);
      out += text.substr(i + 1, end - i);
      i = end + 1;
    } else if (text[i] == '$' && i + 1 < text.size() && (text[i + 1] == '{' || text[i + 1] == '(')) {
      const std::size_t end = end_of(text, i);
      const std::string inner = text.substr(i + 2, end - i - 2);
      Value value;
      if (text[i + 1] == '{') {
        auto answer = evaluate(inner, [&](std::string_view name) { return value_named(name, scope); });
        if (!answer) trail_.fail("${" + inner.substr(0, 80) + "}: " + answer.error());
        value = std::move(*answer);
      } else {
        value = value_of(substitution(to_text(evaluate_text(inner, scope))));
        if (!(i == 0 && end + 1 == text.size())) value = to_text(value);
      }
      if (i == 0 && end + 1 == text.size()) single = value;
      out += to_text(value);
      i = end + 1;
    } else {
      out += text[i++];
    }
    if (out.size() > kLongestText) trail_.fail("a text becomes longer than 1 MiB");
  }
  return single ? *single : Value{std::move(out)};
}

Result<Value, std::string> Texts::value_named(std::string_view name, const Scope& scope) {
  const Scope* const owner = scope.owner_of(name);
  if (owner == nullptr) {
    std::vector<std::string> names;
    scope.append_names(names);
    return err("there is no property '" + std::string(name.substr(0, 60)) + "'; " +
               suggestion(name.substr(0, 60), names));
  }
  const Property& property = *owner->find(name);
  if (property.is_block) return err("'" + std::string(name) + "' is a block; insert it with xacro:insert_block");
  const Reading reading{owner, std::string(name)};
  if (std::find(being_read_.begin(), being_read_.end(), reading) != being_read_.end())
    return err("the property '" + std::string(name) + "' is made of itself");
  if (being_read_.size() > Trail::kMaxDepth) return err(std::string{"properties are nested too deeply"});
  if (++reads_ > kMaxReads) return err(std::string{"properties are read more than a million times"});
  being_read_.push_back(reading);
  // Lazy evaluation, with the names of the scope that defines the property.
  Value value = evaluate_text(property.text, *owner);
  being_read_.pop_back();
  if (const auto* read = std::get_if<std::string>(&value)) return value_of(*read);
  return value;
}

void Texts::check_arguments(const std::string& path) const {
  for (const auto& [name, value] : given_) {
    if (defaults_.count(name) != 0 || std::find(asked_.begin(), asked_.end(), name) != asked_.end()) continue;
    std::vector<std::string> names;
    for (const auto& [key, fallback] : defaults_) names.push_back(key);
    throw Failure{{path, "declares no argument '" + name.substr(0, 60) + "'", suggestion(name.substr(0, 60), names)}};
  }
}

}  // namespace nacelle::description
