// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/utf16.hpp"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>
#include <cstring>

namespace nacelle::msgs {
namespace {

template <typename Number>
Number load(const void* at) {
  Number value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <typename Integer>
void write_integer(std::string& out, const void* at) {
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, load<Integer>(at)).ptr;
  out.append(digits, end);
}

void write_float(std::string& out, double value) {
  if (!std::isfinite(value)) {
    out += std::isnan(value) ? "\"NaN\"" : value > 0 ? "\"Infinity\"" : "\"-Infinity\"";
    return;
  }
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  const std::string_view text{digits, static_cast<std::size_t>(end - digits)};
  out += text;
  if (text.find_first_of(".e") == std::string_view::npos) out += ".0";  // Keeps it a float for readers of the JSON.
}

void write_text(std::string& out, const std::string& text) {
  out += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void write_message(std::string& out, const MessageType& type, const void* message);

void write_value(std::string& out, const Field& field, const void* at) {
  switch (field.kind) {
    case Kind::Bool: out += load<std::uint8_t>(at) != 0 ? "true" : "false"; break;
    case Kind::Byte:
    case Kind::Char:
    case Kind::Uint8: write_integer<std::uint8_t>(out, at); break;
    case Kind::Int8: write_integer<std::int8_t>(out, at); break;
    case Kind::Int16: write_integer<std::int16_t>(out, at); break;
    case Kind::Uint16: write_integer<std::uint16_t>(out, at); break;
    case Kind::Int32: write_integer<std::int32_t>(out, at); break;
    case Kind::Uint32: write_integer<std::uint32_t>(out, at); break;
    case Kind::Int64: write_integer<std::int64_t>(out, at); break;
    case Kind::Uint64: write_integer<std::uint64_t>(out, at); break;
    case Kind::Float32: write_float(out, static_cast<double>(load<float>(at))); break;
    case Kind::Float64: write_float(out, load<double>(at)); break;
    case Kind::String: write_text(out, *static_cast<const std::string*>(at)); break;
    case Kind::WString: write_text(out, utf8_of(*static_cast<const std::u16string*>(at))); break;
    case Kind::Message: write_message(out, field.message(), at); break;
  }
}

void write_field(std::string& out, const Field& field, const void* at) {
  if (field.shape == Shape::Single) {
    write_value(out, field, at);
    return;
  }
  const bool fixed = field.shape == Shape::Array;
  const std::size_t count = fixed ? field.bound : field.sequence->size(at);
  const std::size_t stride = fixed ? element_size(field) : field.sequence->stride;
  const auto* element = static_cast<const std::uint8_t*>(fixed ? at : field.sequence->data(at));
  out += '[';
  for (std::size_t i = 0; i < count; ++i, element += stride) {
    if (i != 0) out += ',';
    write_value(out, field, element);
  }
  out += ']';
}

void write_message(std::string& out, const MessageType& type, const void* message) {
  out += '{';
  bool first = true;
  for (const Field& field : type.fields) {
    if (!first) out += ',';
    first = false;
    out += '"';
    out += field.name;
    out += "\":";
    write_field(out, field, static_cast<const std::uint8_t*>(message) + field.offset);
  }
  out += '}';
}

}  // namespace

std::string to_json(const MessageType& type, const void* message) {
  std::string out;
  write_message(out, type, message);
  return out;
}

}  // namespace nacelle::msgs
