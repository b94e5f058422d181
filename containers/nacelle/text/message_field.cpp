// SPDX-License-Identifier: Apache-2.0
#include "text/message_field.hpp"

#include <algorithm>
#include <span>
#include <vector>

#include "nacelle/msgs/json.hpp"

namespace nacelle::text {

using msgs::Field;
using msgs::Kind;
using msgs::Shape;

namespace {

Problem unknown(const msgs::MessageType& type, std::string_view path, const std::string& name) {
  std::vector<std::string> names;
  for (const Field& field : type.fields) names.emplace_back(field.name);
  const std::string near = nearest_name(name, names);
  std::string way_out = names.empty() ? "it has no fields" : "its fields are " + join(names);
  if (!near.empty()) way_out = "did you mean '" + near + "'? " + way_out;
  return {"field " + std::string{path}, "there is no '" + name + "' in " + type.name, way_out};
}

}  // namespace

MessageField::MessageField(const msgs::MessageType& owner, const Field& field, std::size_t offset)
    : only_(owner), offset_(offset) {
  only_.fields = std::span<const Field>{&field, 1};
}

Result<MessageField, Problem> MessageField::find(const msgs::MessageType& type, std::string_view path) {
  const msgs::MessageType* owner = &type;
  std::size_t offset = 0;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string name{path.substr(begin, end - begin)};
    const auto field = std::ranges::find_if(owner->fields, [&](const Field& one) { return one.name == name; });
    if (field == owner->fields.end()) return err(unknown(*owner, path, name));
    if (end == path.size()) return MessageField{*owner, *field, offset};
    const std::string so_far{path.substr(0, end)};
    if (field->shape != Shape::Single)
      return err(Problem{"field " + std::string{path}, so_far + " is a list", "give --field " + so_far});
    if (field->kind != Kind::Message)
      return err(
          Problem{"field " + std::string{path}, so_far + " is a value without fields", "give --field " + so_far});
    offset += field->offset;
    owner = &field->message();
    begin = end + 1;
  }
}

void MessageField::append_yaml(std::string& out, const void* message, const YamlOptions& options) const {
  const void* const owner = static_cast<const std::byte*>(message) + offset_;
  const Field& field = only_.fields.front();
  const void* const at = static_cast<const std::byte*>(owner) + field.offset;
  if (field.shape == Shape::Single && field.kind == Kind::Message) {
    text::append_yaml(out, field.message(), at, options);
    return;
  }
  if (field.shape == Shape::Single && field.kind == Kind::String) {
    // Without quotes: `--field data > robot.urdf` writes the file.
    const auto& text = *static_cast<const std::string*>(at);
    const bool cut = options.longest != 0 && text.size() > options.longest;
    out += cut ? text.substr(0, options.longest) + "..." : text;
    if (!out.ends_with('\n')) out.push_back('\n');
    return;
  }
  std::string named;
  text::append_yaml(named, only_, owner, options);
  // "x: 1.0\n" or, of a list, "ranges:\n- 1.0\n": the name goes.
  out += std::string_view{named}.substr(std::string_view{field.name}.size() + 2);
}

std::string MessageField::to_json(const void* message) const {
  const std::string named = msgs::to_json(only_, static_cast<const std::byte*>(message) + offset_);
  // {"x":1.0}
  const std::size_t front = std::string_view{only_.fields.front().name}.size() + 4;
  return named.substr(front, named.size() - front - 1);
}

}  // namespace nacelle::text
