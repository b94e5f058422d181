// SPDX-License-Identifier: Apache-2.0
#include "text/message_yaml.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <iterator>
#include <string_view>

#include "nacelle/base/printable.hpp"
#include "nacelle/msgs/utf16.hpp"

namespace nacelle::text {
namespace {

using msgs::Field;
using msgs::Kind;
using msgs::Shape;

template <typename T>
T load(const void* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

void append_float(std::string& out, double value, bool single) {
  if (std::isnan(value)) {
    out += ".nan";
  } else if (std::isinf(value)) {
    out += value < 0 ? "-.inf" : ".inf";
  } else {
    // The shortest text that reads back as the same number.
    const std::size_t begin = out.size();
    if (single) {
      fmt::format_to(std::back_inserter(out), "{}", static_cast<float>(value));
    } else {
      fmt::format_to(std::back_inserter(out), "{}", value);
    }
    if (out.find_first_of(".e", begin) == std::string::npos) out += ".0";
  }
}

bool needs_quotes(std::string_view text) {
  if (text.empty()) return true;
  for (const std::string_view word : {"true", "false", "yes", "no", "on", "off", "null", "~"}) {
    if (text == word) return true;
  }
  // Whatever may be read as a number, a list, a comment or the like.
  if (std::string_view{"-+.0123456789[]{},#&*!|>'\"%@` :?"}.find(text.front()) != std::string_view::npos) return true;
  return text.back() == ' ' || text.back() == ':' || text.find(": ") != std::string_view::npos ||
         text.find(" #") != std::string_view::npos;
}

void append_text(std::string& out, std::string_view text, const YamlOptions& options) {
  std::string shown{text};
  if (options.longest != 0 && shown.size() > options.longest) shown = shown.substr(0, options.longest) + "...";
  if (!is_printable_line(shown)) {
    out.push_back('"');
    for (std::size_t at = 0; at < shown.size(); ++at) {
      const char c = shown[at];
      if (c == '"' || c == '\\') {
        out.push_back('\\');
        out.push_back(c);
      } else if (c == '\n') {
        out += "\\n";
      } else if (const std::size_t bytes = control_bytes(shown, at); bytes != 0) {
        at += bytes - 1;
        fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned char>(shown[at]));
      } else {
        out.push_back(c);
      }
    }
    out.push_back('"');
  } else if (needs_quotes(shown)) {
    out.push_back('\'');
    for (const char c : shown) out.append(c == '\'' ? 2 : 1, c);
    out.push_back('\'');
  } else {
    out += shown;
  }
}

void append_value(std::string& out, const Field& field, const void* at, const YamlOptions& options) {
  const auto number = [&out](auto value) { fmt::format_to(std::back_inserter(out), "{}", value); };
  switch (field.kind) {
    case Kind::Bool: out += load<std::uint8_t>(at) != 0 ? "true" : "false"; break;
    case Kind::Byte:
    case Kind::Char:
    case Kind::Uint8: number(static_cast<unsigned>(load<std::uint8_t>(at))); break;
    case Kind::Int8: number(static_cast<int>(load<std::int8_t>(at))); break;
    case Kind::Int16: number(load<std::int16_t>(at)); break;
    case Kind::Uint16: number(load<std::uint16_t>(at)); break;
    case Kind::Int32: number(load<std::int32_t>(at)); break;
    case Kind::Uint32: number(load<std::uint32_t>(at)); break;
    case Kind::Int64: number(load<std::int64_t>(at)); break;
    case Kind::Uint64: number(load<std::uint64_t>(at)); break;
    case Kind::Float32: append_float(out, static_cast<double>(load<float>(at)), true); break;
    case Kind::Float64: append_float(out, load<double>(at), false); break;
    case Kind::String: append_text(out, *static_cast<const std::string*>(at), options); break;
    case Kind::WString: append_text(out, msgs::utf8_of(*static_cast<const std::u16string*>(at)), options); break;
    case Kind::Message: break;  // append_message()
  }
}

void append_message(std::string& out, const msgs::MessageType& type, const void* message, const YamlOptions& options,
                    std::size_t indent, bool first_on_line);

std::size_t stride_of(const Field& field) {
  switch (field.kind) {
    case Kind::Message: return field.message().size;
    case Kind::String: return sizeof(std::string);
    case Kind::WString: return sizeof(std::u16string);
    default: return msgs::number_size(field.kind);
  }
}

void append_elements(std::string& out, const Field& field, const void* first, std::size_t count, std::size_t stride,
                     const YamlOptions& options, std::size_t indent) {
  if (count == 0) {
    out += " []\n";
    return;
  }
  out.push_back('\n');
  const std::size_t shown = options.longest == 0 ? count : std::min(count, options.longest);
  for (std::size_t i = 0; i < shown; ++i) {
    const void* const at = static_cast<const std::byte*>(first) + i * stride;
    out.append(indent, ' ').append("- ");
    if (field.kind == Kind::Message) {
      append_message(out, field.message(), at, options, indent + 2, true);
    } else {
      append_value(out, field, at, options);
      out.push_back('\n');
    }
  }
  if (shown < count) out.append(indent, ' ').append("- '...'\n");
}

void append_message(std::string& out, const msgs::MessageType& type, const void* message, const YamlOptions& options,
                    std::size_t indent, bool first_on_line) {
  if (type.fields.empty()) {
    out.append(first_on_line ? 0 : indent, ' ').append("{}\n");
    return;
  }
  for (const Field& field : type.fields) {
    out.append(first_on_line ? 0 : indent, ' ').append(field.name).push_back(':');
    first_on_line = false;
    const void* const at = static_cast<const std::byte*>(message) + field.offset;
    if (field.shape == Shape::Array) {
      append_elements(out, field, at, field.bound, stride_of(field), options, indent);
    } else if (field.shape != Shape::Single) {
      append_elements(out, field, field.sequence->data(at), field.sequence->size(at), field.sequence->stride, options,
                      indent);
    } else if (field.kind == Kind::Message) {
      if (field.message().fields.empty()) {
        out += " {}\n";
      } else {
        out.push_back('\n');
        append_message(out, field.message(), at, options, indent + 2, false);
      }
    } else {
      out.push_back(' ');
      append_value(out, field, at, options);
      out.push_back('\n');
    }
  }
}

}  // namespace

void append_yaml(std::string& out, const msgs::MessageType& type, const void* message, const YamlOptions& options) {
  append_message(out, type, message, options, 0, false);
}

}  // namespace nacelle::text
