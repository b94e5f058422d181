// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/json_text.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/json.hpp"
#include "nacelle/msgs/message_fault.hpp"
#include "nacelle/msgs/utf16.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

namespace nacelle::msgs {
namespace {

using Json = nlohmann::json;
using Outcome = Result<void, Problem>;

/// Where a value stands; kept as a chain so that the text is made only for a person.
struct Path {
  const Path* above;
  std::string_view name;
  std::size_t index;

  [[nodiscard]] std::string text() const {
    const std::string before = above != nullptr ? above->text() : "";
    if (name.empty()) return before + "[" + std::to_string(index) + "]";
    return before.empty() ? std::string(name) : before + "." + std::string(name);
  }
};

std::string shown(const Json& value) {
  constexpr std::size_t kMost = 60;
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > kMost) text = text.substr(0, kMost) + "...";
  return text;
}

Outcome refuse(const Path& path, const Json& value, const std::string& wanted,
               MessageFault fault = MessageFault::WrongType) {
  return err(Problem{path.text(), shown(value) + " is not " + wanted, "", fault, shown(value)});
}

template <typename Integer>
Outcome read_integer(const Json& value, void* at, const Path& path, Kind kind) {
  using Limits = std::numeric_limits<Integer>;
  const auto in_range = [](auto wide) { return std::in_range<Integer>(wide); };
  Integer number{};
  if (value.is_number_unsigned() && in_range(value.get<std::uint64_t>())) {
    number = static_cast<Integer>(value.get<std::uint64_t>());
  } else if (value.is_number_integer() && !value.is_number_unsigned() && in_range(value.get<std::int64_t>())) {
    number = static_cast<Integer>(value.get<std::int64_t>());
  } else if (value.is_number()) {
    return refuse(path, value,
                  std::string("a whole number from ") + std::to_string(Limits::min()) + " to " +
                      std::to_string(Limits::max()) + " (" + kind_name(kind) + ")",
                  MessageFault::OutOfRange);
  } else {
    return refuse(path, value, std::string("a number (") + kind_name(kind) + ")");
  }
  std::memcpy(at, &number, sizeof number);
  return {};
}

template <typename Float>
Outcome read_float(const Json& value, void* at, const Path& path, Kind kind) {
  using Limits = std::numeric_limits<Float>;
  Float number{};
  if (value.is_number()) {
    const auto wide = value.get<double>();
    // Beyond the largest float by less than half a step still rounds to it.
    if (std::isinf(static_cast<Float>(wide)))
      return refuse(path, value, std::string("in the range of a ") + kind_name(kind), MessageFault::OutOfRange);
    number = static_cast<Float>(wide);
  } else if (value == "NaN") {
    number = Limits::quiet_NaN();
  } else if (value == "Infinity") {
    number = Limits::infinity();
  } else if (value == "-Infinity") {
    number = -Limits::infinity();
  } else {
    return refuse(path, value,
                  std::string("a number, \"NaN\", \"Infinity\" or \"-Infinity\" (") + kind_name(kind) + ")");
  }
  std::memcpy(at, &number, sizeof number);
  return {};
}

Outcome read_text(const Json& value, void* at, const Path& path, const Field& field) {
  if (!value.is_string()) return refuse(path, value, "a string");
  const auto& text = value.get_ref<const std::string&>();
  std::size_t length = text.size();
  if (field.kind == Kind::String) {
    *static_cast<std::string*>(at) = text;
  } else {
    auto& wide = *static_cast<std::u16string*>(at);
    wide = utf16_of(text);
    length = wide.size();
  }
  if (field.text_bound != 0 && length > field.text_bound) {
    return refuse(path, value, "at most " + std::to_string(field.text_bound) + " characters long",
                  MessageFault::WrongLength);
  }
  return {};
}

Outcome read_message(const Json& value, const MessageType& type, void* message, const Path* path);

Outcome read_value(const Json& value, const Field& field, void* at, const Path& path) {
  switch (field.kind) {
    case Kind::Bool:
      if (!value.is_boolean()) return refuse(path, value, "true or false");
      *static_cast<bool*>(at) = value.get<bool>();
      return {};
    case Kind::Byte:
    case Kind::Char:
    case Kind::Uint8: return read_integer<std::uint8_t>(value, at, path, field.kind);
    case Kind::Int8: return read_integer<std::int8_t>(value, at, path, field.kind);
    case Kind::Int16: return read_integer<std::int16_t>(value, at, path, field.kind);
    case Kind::Uint16: return read_integer<std::uint16_t>(value, at, path, field.kind);
    case Kind::Int32: return read_integer<std::int32_t>(value, at, path, field.kind);
    case Kind::Uint32: return read_integer<std::uint32_t>(value, at, path, field.kind);
    case Kind::Int64: return read_integer<std::int64_t>(value, at, path, field.kind);
    case Kind::Uint64: return read_integer<std::uint64_t>(value, at, path, field.kind);
    case Kind::Float32: return read_float<float>(value, at, path, field.kind);
    case Kind::Float64: return read_float<double>(value, at, path, field.kind);
    case Kind::String:
    case Kind::WString: return read_text(value, at, path, field);
    case Kind::Message: return read_message(value, field.message(), at, &path);
  }
  return {};
}

Outcome read_field(const Json& value, const Field& field, void* at, const Path& path) {
  if (field.shape == Shape::Single) return read_value(value, field, at, path);
  if (!value.is_array()) return refuse(path, value, "an array");
  std::uint8_t* element = nullptr;
  std::size_t stride = 0;
  if (field.shape == Shape::Array) {
    if (value.size() != field.bound) {
      return refuse(path, value,
                    "an array of " + std::to_string(field.bound) + " (it has " + std::to_string(value.size()) + ")",
                    MessageFault::WrongLength);
    }
    element = static_cast<std::uint8_t*>(at);
    stride = element_size(field);
  } else {
    if (field.bound != 0 && value.size() > field.bound) {
      return refuse(
          path, value,
          "an array of at most " + std::to_string(field.bound) + " (it has " + std::to_string(value.size()) + ")",
          MessageFault::WrongLength);
    }
    field.sequence->resize(at, 0);  // So that each element begins with its defaults, not with the field's.
    field.sequence->resize(at, value.size());
    element = static_cast<std::uint8_t*>(field.sequence->mutable_data(at));
    stride = field.sequence->stride;
  }
  for (std::size_t i = 0; i < value.size(); ++i, element += stride) {
    if (auto done = read_value(value[i], field, element, Path{&path, "", i}); !done) return done;
  }
  return {};
}

Outcome read_message(const Json& value, const MessageType& type, void* message, const Path* path) {
  if (!value.is_object()) {
    const Path root{nullptr, type.name, 0};
    return refuse(path != nullptr ? *path : root, value, std::string("an object (") + type.name + ")");
  }
  std::size_t used = 0;
  for (const Field& field : type.fields) {
    const auto entry = value.find(field.name);
    if (entry == value.end()) continue;
    ++used;
    auto* const at = static_cast<std::uint8_t*>(message) + field.offset;
    if (auto done = read_field(*entry, field, at, Path{path, field.name, 0}); !done) return done;
  }
  if (used == value.size()) return {};
  std::vector<std::string> names;
  for (const Field& field : type.fields) names.emplace_back(field.name);
  for (const auto& [name, ignored] : value.items()) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      return err(Problem{
          Path{path, name.empty() ? "\"\"" : name, 0}.text(), std::string("there is no such field in ") + type.name,
          names.empty() ? "it has no fields" : suggestion(name, names), MessageFault::UnknownField, name});
    }
  }
  return {};
}

/// What nlohmann's parser lets pass and a person would not: two equal names in one object (it keeps the last in silence).
class Guard {
 public:
  bool operator()(int /*depth*/, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) names_.emplace_back();
    if (event == Json::parse_event_t::object_end) names_.pop_back();
    if (event == Json::parse_event_t::key && !names_.back().insert(parsed.get_ref<const std::string&>()).second) {
      twice_ = parsed.get_ref<const std::string&>();
    }
    return true;
  }
  [[nodiscard]] const std::optional<std::string>& twice() const { return twice_; }

 private:
  std::vector<std::set<std::string>> names_;
  std::optional<std::string> twice_;
};

}  // namespace

Result<void, Problem> from_json(std::string_view text, const MessageType& type, void* message) {
  Guard guard;
  auto parsed = parse_json(text, std::ref(guard));
  if (!parsed) return err(Problem{type.name, parsed.error().text(), "", MessageFault::Malformed});
  if (const auto& name = guard.twice())
    return err(Problem{type.name, "the field \"" + *name + "\" is given twice", "", MessageFault::Twice, *name});
  AnyMessage scratch{type};
  if (auto done = read_message(parsed.value(), type, scratch.get(), nullptr); !done) return done;
  type.move_assign(message, scratch.get());
  return {};
}

}  // namespace nacelle::msgs
