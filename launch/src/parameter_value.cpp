// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/parameter_value.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/printable.hpp"
#include "nacelle/launch/launch_fault.hpp"
#include "shown.hpp"

namespace nacelle::launch {
namespace {

constexpr std::array<std::string_view, 11> kTrue{"Y",    "y",    "yes", "Yes", "YES", "true",
                                                 "True", "TRUE", "on",  "On",  "ON"};
constexpr std::array<std::string_view, 11> kFalse{"N",     "n",     "no",  "No",  "NO", "false",
                                                  "False", "FALSE", "off", "Off", "OFF"};

std::optional<bool> as_bool(std::string_view text) {
  if (std::find(kTrue.begin(), kTrue.end(), text) != kTrue.end()) return true;
  if (std::find(kFalse.begin(), kFalse.end(), text) != kFalse.end()) return false;
  return std::nullopt;
}

bool take_sign(std::string_view& text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  return negative;
}

// strtoll with base 0, without its dependence on the locale.
std::optional<std::int64_t> as_int(std::string_view text) {
  const bool negative = take_sign(text);
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
  } else if (text.size() > 1 && text[0] == '0') {
    base = 8;
  }
  std::uint64_t magnitude = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), magnitude, base);
  if (fault != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  constexpr std::uint64_t kMost = std::uint64_t{1} << 63U;
  if (magnitude > kMost - (negative ? 0 : 1)) return std::nullopt;
  return static_cast<std::int64_t>(negative ? ~magnitude + 1 : magnitude);
}

// strtod, without its dependence on the locale, plus YAML's .nan and .inf.
std::optional<double> as_double(std::string_view text) {
  const bool negative = take_sign(text);
  const double sign = negative ? -1.0 : 1.0;
  if (text == ".nan" || text == ".NaN" || text == ".NAN") return std::nan("");
  if (text == ".inf" || text == ".Inf" || text == ".INF") return sign * INFINITY;
  if (text.starts_with('-') || text.starts_with('+')) return std::nullopt;
  double value = 0.0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return sign * value;
}

ParameterValue value_of_one(const YamlNode& node) {
  if (node.quoted || node.tag == "str") return node.text;
  return value_of_scalar(node.text);
}

template <typename T>
ParameterValue list_of(const std::vector<ParameterValue>& values) {
  std::vector<T> list;
  for (const auto& value : values) list.push_back(*std::get_if<T>(&value));
  return list;
}

Result<ParameterValue, Problem> value_of_list(const std::vector<YamlNode>& items) {
  std::vector<ParameterValue> values;
  for (const YamlNode& item : items) {
    if (!item.is_scalar())
      return err(Problem{"", std::string("a list may hold only plain values, not ") + item.kind_text(), "",
                         LaunchFault::Form});
    values.push_back(value_of_one(item));
    if (values.back().index() == values.front().index()) continue;
    return err(Problem{"",
                       "the list mixes " + type_name(values.front()) + " and " + type_name(values.back()) + " ('" +
                           shown(item.text) + "')",
                       "write all of them as one type, such as 1.0 instead of 1", LaunchFault::Form});
  }
  if (values.empty()) return ParameterValue{};
  if (std::holds_alternative<bool>(values[0])) return list_of<bool>(values);
  if (std::holds_alternative<std::int64_t>(values[0])) return list_of<std::int64_t>(values);
  if (std::holds_alternative<double>(values[0])) return list_of<double>(values);
  return list_of<std::string>(values);
}

Problem not_a(std::string_view text, const char* type) {
  return {"", "'" + shown(text) + "' is not of the type " + type, "", LaunchFault::WrongValue};
}

constexpr std::array<const char*, 9> kTypeWords{"any",          "bool",        "int",           "float",      "str",
                                                "list_of_bool", "list_of_int", "list_of_float", "list_of_str"};

Result<ParameterValue, Problem> forced_list(const YamlNode& node, ForcedType type) {
  const auto refused = [&] {
    return err(Problem{"", std::string("the list is not of the type ") + kTypeWords[static_cast<std::size_t>(type)], "",
                       LaunchFault::WrongValue});
  };
  if (type == ForcedType::ListOfStr) {
    std::vector<std::string> list;
    for (const YamlNode& item : node.items) {
      if (!item.is_scalar()) return refused();
      list.push_back(item.text);
    }
    return ParameterValue{std::move(list)};
  }
  auto value = value_of_list(node.items);
  if (!value) return value;
  if (node.items.empty()) {
    if (type == ForcedType::ListOfBool) return ParameterValue{std::vector<bool>{}};
    if (type == ForcedType::ListOfInt) return ParameterValue{std::vector<std::int64_t>{}};
    if (type == ForcedType::ListOfFloat) return ParameterValue{std::vector<double>{}};
  }
  if (type == ForcedType::ListOfBool && std::holds_alternative<std::vector<bool>>(*value)) return value;
  const auto* ints = std::get_if<std::vector<std::int64_t>>(&*value);
  if (type == ForcedType::ListOfInt && ints != nullptr) return value;
  if (type == ForcedType::ListOfFloat && ints != nullptr)
    return ParameterValue{std::vector<double>(ints->begin(), ints->end())};
  if (type == ForcedType::ListOfFloat && std::holds_alternative<std::vector<double>>(*value)) return value;
  return refused();
}

// Text that stays text when it is read again.
std::string quoted_if_needed(const std::string& text) {
  const bool plain = !text.empty() && std::holds_alternative<std::string>(value_of_scalar(text)) && text != "~" &&
                     text != "null" && text != "Null" && text != "NULL" &&
                     std::all_of(text.begin(), text.end(), [](char c) {
                       return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
                              c == '/' || c == '.';
                     });
  if (plain) return text;
  std::string out = "\"";
  constexpr std::string_view kHex = "0123456789abcdef";
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (const std::size_t bytes = control_bytes(text, at); bytes != 0) {
      at += bytes - 1;
      const auto byte = static_cast<unsigned char>(text[at]);
      out += "\\x";
      out += kHex[byte >> 4U];
      out += kHex[byte & 15U];
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string number_text(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value < 0 ? "-.inf" : ".inf";
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  std::string text(buffer.data(), end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string one_text(bool value) { return value ? "true" : "false"; }
std::string one_text(std::int64_t value) { return std::to_string(value); }
std::string one_text(std::uint8_t value) { return std::to_string(value); }
std::string one_text(double value) { return number_text(value); }
std::string one_text(const std::string& value) { return quoted_if_needed(value); }
std::string one_text(std::monostate /*unset*/) { return {}; }
template <typename T>
std::string one_text(const std::vector<T>& values) {
  std::string text = "[";
  for (const auto& value : values) text += (text.size() > 1 ? ", " : "") + one_text(static_cast<T>(value));
  return text + "]";
}

}  // namespace

ParameterValue value_of_scalar(std::string_view text) {
  if (const auto value = as_bool(text)) return *value;
  if (const auto value = as_int(text)) return *value;
  if (const auto value = as_double(text)) return *value;
  return std::string(text);
}

Result<ParameterValue, Problem> value_of_node(const YamlNode& node, ForcedType type) {
  if (node.is_scalar())
    return type == ForcedType::None ? Result<ParameterValue, Problem>(value_of_one(node))
                                    : value_of_type(node.text, type);
  if (node.is_sequence() && type == ForcedType::None) return value_of_list(node.items);
  if (node.is_sequence() && type >= ForcedType::ListOfBool) return forced_list(node, type);
  const std::string wanted =
      type == ForcedType::None ? "a value or a list of values" : kTypeWords[static_cast<std::size_t>(type)];
  return err(Problem{"", "expected " + wanted + ", found " + node.kind_text(), "", LaunchFault::Form});
}

Result<ParameterValue, Problem> value_of_text(std::string_view text) {
  // Only what looks like a list or a quoted text is YAML; "a: b" or "# 1" stay what they are.
  if (text.empty() || (text.front() != '[' && text.front() != '\'' && text.front() != '"'))
    return value_of_scalar(text);
  const auto node = parse_yaml(text, "");
  if (!node || !(node->is_scalar() || node->is_sequence())) return ParameterValue{std::string(text)};
  return value_of_node(*node);
}

Result<ParameterValue, Problem> value_of_type(std::string_view text, ForcedType type) {
  switch (type) {
    case ForcedType::None: return value_of_text(text);
    case ForcedType::Str: return ParameterValue{std::string(text)};
    case ForcedType::Bool:
      if (const auto value = as_bool(text)) return ParameterValue{*value};
      return err(not_a(text, "bool"));
    case ForcedType::Int:
      if (const auto value = as_int(text)) return ParameterValue{*value};
      return err(not_a(text, "int"));
    case ForcedType::Float:
      if (const auto value = as_double(text)) return ParameterValue{*value};
      if (const auto value = as_int(text)) return ParameterValue{static_cast<double>(*value)};
      return err(not_a(text, "float"));
    default: break;
  }
  const auto node = parse_yaml(text, "");
  if (!node || !node->is_sequence()) return err(not_a(text, kTypeWords[static_cast<std::size_t>(type)]));
  return forced_list(*node, type);
}

Result<ForcedType, Problem> parse_forced_type(std::string_view word) {
  const std::vector<std::string> words(kTypeWords.begin() + 1, kTypeWords.end());
  const auto found = std::find(words.begin(), words.end(), word);
  if (found != words.end()) return static_cast<ForcedType>(1 + (found - words.begin()));
  return err(Problem{"", "'" + shown(word) + "' is not a type of parameters", suggestion(word.substr(0, 60), words),
                     LaunchFault::WrongValue});
}

Result<void, Problem> validate_parameter_name(std::string_view name) {
  if (name.empty()) return err(Problem{"", "the parameter's name is empty", "", NameFault::Invalid});
  if (name.front() == '.' || name.back() == '.' || name.find("..") != std::string_view::npos) {
    return err(Problem{"", "the parameter name '" + shown(name) + "' has an empty part", "", NameFault::Invalid});
  }
  for (const unsigned char c : name) {  // plain char has a sign on amd64, and none on arm64
    if (c > ' ' && c != 0x7f && c != ':' && c != '=') continue;
    return err(Problem{"",
                       "the parameter name '" + shown(name) + "' holds a space, ':', '=' or an unprintable character",
                       "", NameFault::Invalid});
  }
  return {};
}

Result<std::pair<std::string, ParameterValue>, Problem> parse_parameter_assignment(std::string_view text) {
  const auto split = text.find(":=");
  if (split == std::string_view::npos) {
    return err(Problem{"", "the parameter '" + shown(text) + "' has no ':='", "write name:=value", LaunchFault::Form});
  }
  const auto name = text.substr(0, split);
  if (auto ok = validate_parameter_name(name); !ok) return err(ok.error());
  auto value = value_of_text(text.substr(split + 2));
  if (!value) return err(value.error());
  return std::pair{std::string(name), std::move(*value)};
}

std::string to_text(const ParameterValue& value) {
  return std::visit([](const auto& held) { return one_text(held); }, value);
}

std::string type_name(const ParameterValue& value) {
  constexpr std::array<const char*, 10> kNames{"not set", "bool",   "int",   "double",   "string",
                                               "byte[]",  "bool[]", "int[]", "double[]", "string[]"};
  return kNames[value.index()];
}

}  // namespace nacelle::launch
