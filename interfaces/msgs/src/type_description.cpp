// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/type_description.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace nacelle::msgs {
namespace {

using Described = ::type_description_interfaces::msg::IndividualTypeDescription;
using FieldMessage = ::type_description_interfaces::msg::Field;
using FieldType = ::type_description_interfaces::msg::FieldType;

std::uint8_t id_of(Kind kind, bool has_bound) {
  switch (kind) {
    case Kind::Bool: return FieldType::FIELD_TYPE_BOOLEAN;
    case Kind::Byte: return FieldType::FIELD_TYPE_BYTE;
    case Kind::Char:
    case Kind::Uint8: return FieldType::FIELD_TYPE_UINT8;
    case Kind::Int8: return FieldType::FIELD_TYPE_INT8;
    case Kind::Int16: return FieldType::FIELD_TYPE_INT16;
    case Kind::Uint16: return FieldType::FIELD_TYPE_UINT16;
    case Kind::Int32: return FieldType::FIELD_TYPE_INT32;
    case Kind::Uint32: return FieldType::FIELD_TYPE_UINT32;
    case Kind::Int64: return FieldType::FIELD_TYPE_INT64;
    case Kind::Uint64: return FieldType::FIELD_TYPE_UINT64;
    case Kind::Float32: return FieldType::FIELD_TYPE_FLOAT;
    case Kind::Float64: return FieldType::FIELD_TYPE_DOUBLE;
    case Kind::String: return has_bound ? FieldType::FIELD_TYPE_BOUNDED_STRING : FieldType::FIELD_TYPE_STRING;
    case Kind::WString: return has_bound ? FieldType::FIELD_TYPE_BOUNDED_WSTRING : FieldType::FIELD_TYPE_WSTRING;
    case Kind::Message: return FieldType::FIELD_TYPE_NESTED_TYPE;
  }
  return FieldType::FIELD_TYPE_NOT_SET;
}

std::uint8_t offset_of(Shape shape) {
  switch (shape) {
    case Shape::Single: return 0;
    case Shape::Array: return FieldType::FIELD_TYPE_INT8_ARRAY - FieldType::FIELD_TYPE_INT8;
    case Shape::BoundedSequence: return FieldType::FIELD_TYPE_INT8_BOUNDED_SEQUENCE - FieldType::FIELD_TYPE_INT8;
    case Shape::Sequence: break;
  }
  return FieldType::FIELD_TYPE_INT8_UNBOUNDED_SEQUENCE - FieldType::FIELD_TYPE_INT8;
}

// As ROS 2's generator writes a value, in Python: True, 1.0, text.
std::string default_text(const char* json) {
  if (json == nullptr) return {};
  const std::string_view text = json;
  if (text == "true") return "True";
  if (text == "false") return "False";
  if (!text.starts_with('"') || text.size() < 2) return std::string(text);
  std::string plain;
  const std::string_view inside = text.substr(1, text.size() - 2);
  for (std::size_t i = 0; i < inside.size(); ++i) {
    if (inside[i] == '\\' && i + 1 < inside.size()) ++i;
    plain += inside[i];
  }
  return plain;
}

FieldMessage field_of(const Field& field) {
  FieldMessage message;
  message.name = field.name;
  message.type.type_id = static_cast<std::uint8_t>(id_of(field.kind, field.text_bound != 0) + offset_of(field.shape));
  message.type.capacity = field.bound;
  message.type.string_capacity = field.text_bound;
  if (field.message != nullptr) message.type.nested_type_name = field.message().name;
  message.default_value = default_text(field.default_json);
  return message;
}

FieldMessage nested_field(std::string name, const char* type) {
  FieldMessage message;
  message.name = std::move(name);
  message.type.type_id = FieldType::FIELD_TYPE_NESTED_TYPE;
  message.type.nested_type_name = type;
  return message;
}

Described described(const char* name, std::vector<FieldMessage> fields) {
  Described one;
  one.type_name = name;
  one.fields = std::move(fields);
  return one;
}

/// Describes types, each once, and those they are made of.
class Collector {
 public:
  Described own(const MessageType& type) {
    std::vector<FieldMessage> fields;
    for (const Field& field : type.fields) {
      fields.push_back(field_of(field));
      if (field.message != nullptr) refer(field.message());
    }
    if (fields.empty()) {  // IDL knows no empty struct
      fields.emplace_back().name = "structure_needs_at_least_one_member";
      fields.back().type.type_id = FieldType::FIELD_TYPE_UINT8;
    }
    return described(type.name, std::move(fields));
  }
  Described own(const ServiceType& type) {
    for (const auto part : {type.request, type.response, type.event}) refer(part());
    return described(type.name, {nested_field("request_message", type.request().name),
                                 nested_field("response_message", type.response().name),
                                 nested_field("event_message", type.event().name)});
  }
  Described own(const ActionType& type) {
    for (const auto part : {type.goal, type.result, type.feedback, type.feedback_message}) refer(part());
    for (const auto part : {type.send_goal, type.get_result}) refer(part());
    return described(type.name, {nested_field("goal", type.goal().name), nested_field("result", type.result().name),
                                 nested_field("feedback", type.feedback().name),
                                 nested_field("send_goal_service", type.send_goal().name),
                                 nested_field("get_result_service", type.get_result().name),
                                 nested_field("feedback_message", type.feedback_message().name)});
  }
  [[nodiscard]] std::vector<Described> referenced() && {
    std::vector<Described> all;
    for (auto& [name, one] : referenced_) all.push_back(std::move(one));
    return all;
  }

 private:
  template <typename Type>
  void refer(const Type& type) {
    // The entry comes first: a type that is reached on two ways is described once.
    if (!referenced_.try_emplace(type.name).second) return;
    Described one = own(type);
    referenced_[type.name] = std::move(one);
  }
  std::map<std::string, Described> referenced_;
};

// "std_msgs/msg/Header" -> its text, out of a definition and those that follow it (MessageType::definition).
std::map<std::string, std::string> texts_in(std::string_view definition, const std::string& own_name) {
  static const std::string kDelimiter = "\n" + std::string(80, '=') + "\nMSG: ";
  std::map<std::string, std::string> texts;
  auto end = definition.find(kDelimiter);
  texts[own_name] = std::string(definition.substr(0, end));
  while (end != std::string_view::npos) {
    definition.remove_prefix(end + kDelimiter.size());
    end = definition.find(kDelimiter);
    const std::string_view piece = definition.substr(0, end);
    const auto line = std::min(piece.find('\n'), piece.size());
    std::string name(piece.substr(0, line));  // "std_msgs/Header"
    if (const auto slash = name.find('/'); slash != std::string::npos) name.insert(slash, "/msg");
    texts[name] = std::string(piece.substr(std::min(line + 1, piece.size())));
  }
  return texts;
}

// "pkg/srv/S" is of a file S.srv.
std::string encoding_of(std::string_view type) {
  const auto first = type.find('/');
  const auto second = first == std::string_view::npos ? first : type.find('/', first + 1);
  return second == std::string_view::npos ? std::string() : std::string(type.substr(first + 1, second - first - 1));
}

constexpr std::string_view kHashPrefix = "RIHS01_";

bool is_type_hash(std::string_view text) {
  constexpr std::size_t kDigits = 64;
  return text.size() == kHashPrefix.size() + kDigits && text.starts_with(kHashPrefix) &&
         text.find_first_not_of("0123456789abcdefABCDEF", kHashPrefix.size()) == std::string_view::npos;
}

const char* hash_of(const UsedType& used) {
  return std::visit([](const auto* type) { return type->hash; }, used);
}

}  // namespace

TypeDescription describe(const UsedType& used) {
  Collector collector;
  TypeDescription description;
  description.type_description = std::visit([&](const auto* type) { return collector.own(*type); }, used);
  description.referenced_type_descriptions = std::move(collector).referenced();
  return description;
}

std::vector<TypeSource> sources_of(const UsedType& used) {
  const TypeDescription description = describe(used);
  const std::string& own_name = description.type_description.type_name;
  const auto texts = texts_in(std::visit([](const auto* type) { return type->definition; }, used), own_name);
  std::vector<TypeSource> sources;
  const auto add = [&](const std::string& name) {
    const auto text = texts.find(name);
    TypeSource& source = sources.emplace_back();
    source.type_name = name;
    source.encoding = text == texts.end() ? "implicit" : encoding_of(name);
    if (text != texts.end()) source.raw_file_contents = text->second;
  };
  add(own_name);
  for (const auto& one : description.referenced_type_descriptions) add(one.type_name);
  return sources;
}

GetTypeDescription::Response answer(const GetTypeDescription::Request& request, std::span<const UsedType> in_use) {
  GetTypeDescription::Response response;
  if (!is_type_hash(request.type_hash)) {
    response.failure_reason = "Failed to parse type hash";
    return response;
  }
  std::string hash = request.type_hash;
  std::transform(hash.begin() + kHashPrefix.size(), hash.end(), hash.begin() + kHashPrefix.size(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto found =
      std::find_if(in_use.begin(), in_use.end(), [&](const UsedType& used) { return hash == hash_of(used); });
  if (found == in_use.end()) {
    response.failure_reason = "Type not currently in use by this node";
    return response;
  }
  response.type_description = describe(*found);
  if (request.include_type_sources) response.type_sources = sources_of(*found);
  response.successful = true;
  return response;
}

}  // namespace nacelle::msgs
