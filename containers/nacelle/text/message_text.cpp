// SPDX-License-Identifier: Apache-2.0
#include "text/message_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "nacelle/base/json_text.hpp"
#include "nacelle/launch/parameter_value.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::text {
namespace {

using msgs::Field;
using msgs::Kind;
using msgs::Shape;
using Json = nlohmann::ordered_json;  // values in parentheses: in braces they are an array of one
using Made = Result<Json, Problem>;

constexpr std::string_view kTime = "builtin_interfaces/msg/Time", kHeader = "std_msgs/msg/Header";

/// Turns YAML into JSON, led by the fields of a type.
class TextReader {
 public:
  explicit TextReader(WallTime now) : now_(now) {}

  [[nodiscard]] bool has_stamps() const { return has_stamps_; }

  Made message(const YamlNode& node, const msgs::MessageType& type, const std::string& path) {
    const std::string_view name = type.name;
    if (node.is_scalar() && ((name == kTime && node.text == "now") || (name == kHeader && node.text == "auto"))) {
      has_stamps_ = true;
      return name == kTime ? stamp() : Json{{"stamp", stamp()}};
    }
    if (node.is_null()) return Json::object();
    if (!node.is_map())
      return refuse(node, path, std::string{"is "} + node.kind_text() + ", not a map of " + type.name);
    Json object = Json::object();
    for (const YamlNode& item : node.items) {
      const std::string at = path.empty() ? item.key : path + "." + item.key;
      if (object.contains(item.key)) return err(Problem{at, "is given twice", "", msgs::MessageFault::Twice, item.key});
      const auto field =
          std::ranges::find_if(type.fields, [&](const Field& candidate) { return candidate.name == item.key; });
      // A name that is none is from_json()'s to refuse: it knows the nearest.
      Made value = field != type.fields.end() ? of_field(item, *field, at) : Made{Json(nullptr)};
      if (!value) return value;
      object[item.key] = std::move(value).value();
    }
    return object;
  }

 private:
  static Made refuse(const YamlNode& node, const std::string& path, std::string what) {
    return err(Problem{path.empty() ? Place("the message", node.line) : Place(path), std::move(what), "",
                       msgs::MessageFault::WrongType, node.text});
  }

  [[nodiscard]] Json stamp() const {
    constexpr std::int64_t kNs = 1'000'000'000;
    return {{"sec", now_.nanoseconds() / kNs}, {"nanosec", now_.nanoseconds() % kNs}};
  }

  Made of_field(const YamlNode& node, const Field& field, const std::string& path) {
    if (field.shape == Shape::Single) return one(node, field, path);
    if (node.is_null()) return Json::array();
    if (!node.is_sequence()) return refuse(node, path, std::string{"is "} + node.kind_text() + ", not a list");
    Json array = Json::array();
    for (const YamlNode& item : node.items) {
      Made value = one(item, field, path + "[" + std::to_string(array.size()) + "]");
      if (!value) return value;
      array.push_back(std::move(value).value());
    }
    return array;
  }

  Made one(const YamlNode& node, const Field& field, const std::string& path) {
    if (field.kind == Kind::Message) return message(node, field.message(), path);
    if (node.is_null() && (field.kind == Kind::String || field.kind == Kind::WString)) return Json("");
    if (!node.is_scalar()) return refuse(node, path, std::string{"is "} + node.kind_text() + ", not a value");
    if (field.kind == Kind::String || field.kind == Kind::WString || node.quoted) return Json(node.text);
    return number(node.text);
  }

  /// What a plain scalar is for a number or a bool; another text stays one, and is refused with the path of its field.
  static Json number(const std::string& text) {
    // Parameters end at int64; a uint64 field does not.
    std::uint64_t wide = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), wide);
    if (fault == std::errc{} && end == text.data() + text.size() && (text.size() == 1 || text.front() != '0'))
      return Json(wide);
    const ParameterValue value = launch::value_of_scalar(text);
    if (const auto* const flag = std::get_if<bool>(&value)) return Json(*flag);
    if (const auto* const whole = std::get_if<std::int64_t>(&value)) return Json(*whole);
    const auto* const real = std::get_if<double>(&value);
    if (real == nullptr) return Json(text);
    if (std::isnan(*real)) return Json("NaN");
    if (std::isinf(*real)) return Json(*real > 0 ? "Infinity" : "-Infinity");
    return Json(*real);
  }

  const WallTime now_;
  bool has_stamps_ = false;
};

/// How a message of that type is written: "write {linear: ..., angular: ...} (...)".
std::string form_of(const msgs::MessageType& type) {
  constexpr std::size_t kShown = 4;
  std::string names;
  for (std::size_t i = 0; i < std::min(type.fields.size(), kShown); ++i)
    names += (i == 0 ? "" : ", ") + std::string{type.fields[i].name} + ": ...";
  if (type.fields.size() > kShown) names += ", ...";
  return "write {" + names + "}, see `nacelle interface show " + type.name + "`";
}

// --- as Python writes it ------------------------------------------------------------------------------------------------

void append_python_text(std::string& out, std::string_view text) {
  const char quote = text.find('\'') != std::string_view::npos && text.find('"') == std::string_view::npos ? '"' : '\'';
  out += quote;
  for (const char c : text) {
    if (c == '\n') {
      out += "\\n";
    } else if (c == '\r') {
      out += "\\r";
    } else if (c == '\t') {
      out += "\\t";
    } else if (c == '\\' || c == quote) {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned char>(c));
    } else {
      out += c;
    }
  }
  out += quote;
}

void append_python_float(std::string& out, const Json& value) {
  if (value.is_string()) {  // "NaN", "Infinity", "-Infinity"
    out += value == "NaN" ? "nan" : value == "Infinity" ? "inf" : "-inf";
    return;
  }
  const std::size_t begin = out.size();
  fmt::format_to(std::back_inserter(out), "{}", value.get<double>());
  if (out.find_first_of(".e", begin) == std::string::npos) out += ".0";
}

void append_repr_of(std::string& out, const msgs::MessageType& type, const Json& message);

void append_repr_of_one(std::string& out, const Field& field, const Json& value) {
  switch (field.kind) {
    case Kind::Bool: out += value.get<bool>() ? "True" : "False"; break;
    case Kind::Byte: fmt::format_to(std::back_inserter(out), "b'\\x{:02x}'", value.get<unsigned>()); break;
    case Kind::Float32:
    case Kind::Float64: append_python_float(out, value); break;
    case Kind::String:
    case Kind::WString: append_python_text(out, value.get_ref<const std::string&>()); break;
    case Kind::Message: append_repr_of(out, field.message(), value); break;
    default: out += value.dump(); break;  // whole numbers
  }
}

void append_repr_of(std::string& out, const msgs::MessageType& type, const Json& message) {
  std::string name = type.name;
  std::ranges::replace(name, '/', '.');
  out += name + "(";
  bool first = true;
  for (const Field& field : type.fields) {
    out += first ? "" : ", ";
    first = false;
    out += std::string{field.name} + "=";
    const Json& value = message.at(field.name);
    if (field.shape == Shape::Single) {
      append_repr_of_one(out, field, value);
      continue;
    }
    out += "[";
    for (std::size_t i = 0; i < value.size(); ++i) {
      out += i == 0 ? "" : ", ";
      append_repr_of_one(out, field, value[i]);
    }
    out += "]";
  }
  out += ")";
}

}  // namespace

Result<MessageText, Problem> read_message_text(std::string_view text, const msgs::MessageType& type, WallTime now) {
  // JSON goes its own way: its escapes are not all YAML's, and its words for NaN are texts here.
  if (!parse_json_or_discard<Json>(text).is_discarded()) return MessageText{std::string{text}, false};
  auto root = parse_yaml(text, "the message");
  TextReader reader{now};
  Made json = root ? reader.message(root.value(), type, "") : Made{err(root.error())};
  if (!json) {
    Problem problem = json.error();
    if (problem.code.empty()) problem.code = msgs::MessageFault::Malformed;
    if (problem.way_out.empty()) problem.way_out = form_of(type);
    return err(problem);
  }
  return MessageText{json.value().dump(-1, ' ', false, Json::error_handler_t::replace), reader.has_stamps()};
}

void append_repr(std::string& out, const msgs::MessageType& type, const void* message) {
  const Json value = parse_json_or_discard<Json>(msgs::to_json(type, message));
  if (!value.is_discarded()) append_repr_of(out, type, value);
}

}  // namespace nacelle::text
