// SPDX-License-Identifier: Apache-2.0
#include "look/component/parameter_json.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

#include "rcl_interfaces/msg/parameter_type.hpp"

namespace nacelle::look {
namespace {

using nlohmann::json;
using rcl_interfaces::msg::ParameterType;
using rcl_interfaces::msg::ParameterValue;

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

template <typename Container>
std::string base64(const Container& bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = (group << 8U) | (k < left ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= left ? kDigits[(group >> (18U - 6U * k)) & 63U] : '=';
  }
  return text;
}

/// Nothing: it is no base64.
std::optional<std::string> from_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t group = 0, count = 0;
  while (text.ends_with('=')) text.remove_suffix(1);
  for (const char digit : text) {
    const auto value = kDigits.find(digit);
    if (value == std::string_view::npos) return std::nullopt;
    group = (group << 6U) | static_cast<std::uint32_t>(value);
    if (++count % 4 == 0) {
      for (const unsigned shift : {16U, 8U, 0U}) bytes += static_cast<char>((group >> shift) & 255U);
      group = 0;
    }
  }
  if (count % 4 == 1) return std::nullopt;
  if (count % 4 == 2) bytes += static_cast<char>((group >> 4U) & 255U);
  if (count % 4 == 3) {
    bytes += static_cast<char>((group >> 10U) & 255U);
    bytes += static_cast<char>((group >> 2U) & 255U);
  }
  return bytes;
}

template <typename Container>
json list_of(const Container& values) {
  json list = json::array();
  for (const auto& value : values) list.push_back(value);
  return list;
}

template <typename Test>
bool all(const json& list, Test test) {
  return std::all_of(list.begin(), list.end(), test);
}

std::optional<ParameterValue> from_list(const json& list, const std::string& type) {
  ParameterValue made;
  if (type == "float64_array") {
    if (!all(list, [](const json& one) { return one.is_number(); })) return std::nullopt;
    made.type = ParameterType::PARAMETER_DOUBLE_ARRAY;
    for (const json& one : list) made.double_array_value.push_back(one.get<double>());
  } else if (all(list, [](const json& one) { return one.is_string(); })) {
    made.type = ParameterType::PARAMETER_STRING_ARRAY;
    for (const json& one : list) made.string_array_value.push_back(one.get<std::string>());
  } else if (all(list, [](const json& one) { return one.is_boolean(); })) {
    made.type = ParameterType::PARAMETER_BOOL_ARRAY;
    for (const json& one : list) made.bool_array_value.push_back(one.get<bool>());
  } else if (all(list, [](const json& one) { return one.is_number_integer(); })) {
    made.type = ParameterType::PARAMETER_INTEGER_ARRAY;
    for (const json& one : list) made.integer_array_value.push_back(one.get<std::int64_t>());
  } else if (all(list, [](const json& one) { return one.is_number(); })) {
    return from_list(list, "float64_array");
  } else {
    return std::nullopt;
  }
  return made;
}

}  // namespace

json parameter_json(const std::string& name, const ParameterValue& value) {
  json made{{"name", name}};
  switch (value.type) {
    case ParameterType::PARAMETER_BOOL: made["value"] = value.bool_value; break;
    case ParameterType::PARAMETER_INTEGER: made["value"] = value.integer_value; break;
    case ParameterType::PARAMETER_DOUBLE:
      made["value"] = value.double_value;
      made["type"] = "float64";
      break;
    case ParameterType::PARAMETER_STRING: made["value"] = std::string{value.string_value}; break;
    case ParameterType::PARAMETER_BYTE_ARRAY:
      made["value"] = base64(value.byte_array_value);
      made["type"] = "byte_array";
      break;
    case ParameterType::PARAMETER_BOOL_ARRAY: made["value"] = list_of(value.bool_array_value); break;
    case ParameterType::PARAMETER_INTEGER_ARRAY: made["value"] = list_of(value.integer_array_value); break;
    case ParameterType::PARAMETER_DOUBLE_ARRAY:
      made["value"] = list_of(value.double_array_value);
      made["type"] = "float64_array";
      break;
    case ParameterType::PARAMETER_STRING_ARRAY: made["value"] = list_of(value.string_array_value); break;
    default: break;
  }
  return made;
}

std::optional<ParameterValue> parameter_value(const json& value, const std::string& type) {
  ParameterValue made;
  if (value.is_null()) return made;
  if (value.is_array()) return from_list(value, type);
  if (type == "byte_array") {
    const auto bytes = value.is_string() ? from_base64(value.get<std::string>()) : std::nullopt;
    if (!bytes) return std::nullopt;
    made.type = ParameterType::PARAMETER_BYTE_ARRAY;
    for (const char byte : *bytes) made.byte_array_value.push_back(static_cast<std::uint8_t>(byte));
  } else if (value.is_boolean()) {
    made.type = ParameterType::PARAMETER_BOOL;
    made.bool_value = value.get<bool>();
  } else if (value.is_string()) {
    made.type = ParameterType::PARAMETER_STRING;
    made.string_value = value.get<std::string>();
  } else if (value.is_number_integer() && type != "float64") {
    made.type = ParameterType::PARAMETER_INTEGER;
    made.integer_value = value.get<std::int64_t>();
  } else if (value.is_number()) {
    made.type = ParameterType::PARAMETER_DOUBLE;
    made.double_value = value.get<double>();
  } else {
    return std::nullopt;
  }
  return made;
}

}  // namespace nacelle::look
