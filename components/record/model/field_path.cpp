// SPDX-License-Identifier: Apache-2.0
#include "record/model/field_path.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>

namespace nacelle::record {
namespace {

using msgs::Field;
using msgs::Kind;
using msgs::MessageType;
using msgs::Shape;

template <typename Number>
Number load(const void* at) {
  Number value{};
  std::memcpy(&value, at, sizeof value);
  return value;
}

Problem wrong(std::string_view path, std::string what, std::string way_out = "") {
  return {"field " + std::string{path}, std::move(what), std::move(way_out)};
}

std::vector<std::string> names_of(const MessageType& type) {
  std::vector<std::string> names;
  for (const Field& field : type.fields) names.emplace_back(field.name);
  return names;
}

Problem unknown(const MessageType& type, std::string_view path, const std::string& name) {
  const std::vector<std::string> names = names_of(type);
  const std::string near = nearest_name(name, names);
  std::string way_out = names.empty() ? "it has no fields" : "its fields are " + join(names);
  if (!near.empty()) way_out = "did you mean '" + near + "'? " + way_out;
  return wrong(path, "there is no '" + name + "' in " + type.name, way_out);
}

/// What a path leads to.
struct Target {
  std::vector<std::pair<const Field*, std::size_t>> parts;  // with the index in a list
  bool is_list = false, has_wildcard = false;
};

Result<Target, Problem> resolve(const MessageType& type, std::string_view text) {
  const auto steps = parse_field_path(text);
  if (!steps) return err(steps.error());
  Target target;
  const MessageType* owner = &type;
  std::string so_far;
  for (const PathStep& step : *steps) {
    if (step.kind == PathStep::Kind::Field) {
      if (target.is_list) return err(wrong(text, so_far + " is a list", "give an index: " + so_far + "[0]"));
      if (owner == nullptr) return err(wrong(text, so_far + " is a value without fields", "give " + so_far));
      const auto field = std::ranges::find_if(owner->fields, [&](const Field& one) { return one.name == step.name; });
      if (field == owner->fields.end()) return err(unknown(*owner, text, step.name));
      so_far += (so_far.empty() ? "" : ".") + step.name;
      target.parts.emplace_back(&*field, 0);
      target.is_list = field->shape != Shape::Single;
      owner = field->kind == Kind::Message ? &field->message() : nullptr;
      if (owner != nullptr && is_time(*owner)) owner = nullptr;
      continue;
    }
    if (!target.is_list) return err(wrong(text, so_far + " is no list", "give it no index"));
    const Field& list = *target.parts.back().first;
    if (step.kind == PathStep::Kind::Element && list.shape == Shape::Array && step.index >= list.bound)
      return err(wrong(text, so_far + " has " + std::to_string(list.bound) + " elements", "the first is [0]"));
    target.parts.back().second = step.index;
    target.is_list = false;
    target.has_wildcard = target.has_wildcard || step.kind == PathStep::Kind::EveryElement;
    so_far += step.kind == PathStep::Kind::Element ? "[" + std::to_string(step.index) + "]" : "[*]";
  }
  return target;
}

double number_of(const Field& field, const void* at) {
  switch (field.kind) {
    case Kind::Bool: return load<std::uint8_t>(at) != 0 ? 1.0 : 0.0;
    case Kind::Byte:
    case Kind::Char:
    case Kind::Uint8: return load<std::uint8_t>(at);
    case Kind::Int8: return load<std::int8_t>(at);
    case Kind::Int16: return load<std::int16_t>(at);
    case Kind::Uint16: return load<std::uint16_t>(at);
    case Kind::Int32: return load<std::int32_t>(at);
    case Kind::Uint32: return load<std::uint32_t>(at);
    case Kind::Int64: return static_cast<double>(load<std::int64_t>(at));
    case Kind::Uint64: return static_cast<double>(load<std::uint64_t>(at));
    case Kind::Float32: return static_cast<double>(load<float>(at));
    case Kind::Float64: return load<double>(at);
    case Kind::Message: return static_cast<double>(nanoseconds_of(field.message(), at)) * 1e-9;
    case Kind::String:
    case Kind::WString: break;
  }
  return 0.0;
}

}  // namespace

Result<std::vector<PathStep>, Problem> parse_field_path(std::string_view text) {
  std::vector<PathStep> steps;
  std::size_t at = 0;
  while (at < text.size() || steps.empty()) {
    if (at < text.size() && text[at] == '[' && !steps.empty()) {
      const std::size_t end = text.find(']', at);
      if (end == std::string_view::npos) return err(wrong(text, "a '[' has no ']'"));
      const std::string_view index = text.substr(at + 1, end - at - 1);
      PathStep step{PathStep::Kind::EveryElement, "", 0};
      if (index != "*") {
        step.kind = PathStep::Kind::Element;
        const auto [stop, error] = std::from_chars(index.data(), index.data() + index.size(), step.index);
        if (index.empty() || error != std::errc{} || stop != index.data() + index.size())
          return err(wrong(text, "'" + std::string{index} + "' is no index", "give a number from 0, or *"));
      }
      steps.push_back(std::move(step));
      at = end + 1;
      continue;
    }
    if (!steps.empty() && text[at++] != '.') return err(wrong(text, "after a ']' stands neither '.' nor '['"));
    const std::size_t end = std::min(text.find_first_of(".[]", at), text.size());
    if (end == at) return err(wrong(text, "a name is empty", "write it as pose.covariance[35]"));
    if (end < text.size() && text[end] == ']') return err(wrong(text, "a ']' has no '['"));
    steps.push_back({PathStep::Kind::Field, std::string{text.substr(at, end - at)}, 0});
    at = end;
  }
  return steps;
}

bool is_time(const MessageType& type) {
  const std::string_view name = type.name;
  return name == "builtin_interfaces/msg/Time" || name == "builtin_interfaces/msg/Duration";
}

std::int64_t nanoseconds_of(const MessageType& type, const void* time) {
  const auto* bytes = static_cast<const std::byte*>(time);
  const std::int64_t seconds = load<std::int32_t>(bytes + type.fields[0].offset);
  return seconds * 1'000'000'000 + load<std::uint32_t>(bytes + type.fields[1].offset);
}

Result<void, Problem> check_field_path(const MessageType& type, std::string_view text) {
  const auto target = resolve(type, text);
  if (!target) return err(target.error());
  return {};
}

Result<NumericField, Problem> NumericField::find(const MessageType& type, std::string_view text) {
  const auto target = resolve(type, text);
  if (!target) return err(target.error());
  if (target->has_wildcard) return err(wrong(text, "'*' stands for many values", "give one index"));
  const std::string path{text};
  if (target->is_list) return err(wrong(text, "it is a list", "give an index: " + path + "[0]"));
  const Field& last = *target->parts.back().first;
  if (last.kind == Kind::String || last.kind == Kind::WString)
    return err(wrong(text, "it is a text", "name a numeric field"));
  if (last.kind == Kind::Message && !is_time(last.message())) {
    const auto names = names_of(last.message());
    return err(
        wrong(text, "it is no number", names.empty() ? "name a numeric field" : "its fields are " + join(names)));
  }
  NumericField field;
  for (const auto& [part, index] : target->parts) field.parts_.push_back({part, index});
  return field;
}

std::optional<double> NumericField::read(const void* message) const {
  const void* at = message;
  for (const Part& part : parts_) {
    const Field& field = *part.field;
    at = static_cast<const std::byte*>(at) + field.offset;
    if (field.shape == Shape::Array) {
      at = static_cast<const std::byte*>(at) + part.index * msgs::element_size(field);
    } else if (field.shape != Shape::Single) {
      if (part.index >= field.sequence->size(at)) return std::nullopt;
      at = static_cast<const std::byte*>(field.sequence->data(at)) + part.index * field.sequence->stride;
    }
  }
  return number_of(*parts_.back().field, at);
}

}  // namespace nacelle::record
