// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/parameter_messages.hpp"

#include <stdexcept>
#include <vector>

namespace nacelle::runtime {
namespace {

template <typename T, typename Sequence>
std::vector<T> vector_of(const Sequence& sequence) {
  return std::vector<T>(sequence.begin(), sequence.end());
}

template <typename To, typename From>
void assign(To& to, const From& from) {
  to.assign(from.begin(), from.end());
}

/// Sets the field that the value's type names.
struct Fill {
  rcl_interfaces::msg::ParameterValue& to;
  void operator()(std::monostate) const {}
  void operator()(bool value) const { to.bool_value = value; }
  void operator()(std::int64_t value) const { to.integer_value = value; }
  void operator()(double value) const { to.double_value = value; }
  void operator()(const std::string& value) const { to.string_value = value; }
  void operator()(const std::vector<std::uint8_t>& value) const { assign(to.byte_array_value, value); }
  void operator()(const std::vector<bool>& value) const { assign(to.bool_array_value, value); }
  void operator()(const std::vector<std::int64_t>& value) const { assign(to.integer_array_value, value); }
  void operator()(const std::vector<double>& value) const { assign(to.double_array_value, value); }
  void operator()(const std::vector<std::string>& value) const { assign(to.string_array_value, value); }
};

}  // namespace

ParameterValue value_of(const std::string& name, const rcl_interfaces::msg::ParameterValue& message) {
  switch (static_cast<ParameterType>(message.type)) {
    case ParameterType::NotSet: return {};
    case ParameterType::Bool: return static_cast<bool>(message.bool_value);
    case ParameterType::Integer: return std::int64_t{message.integer_value};
    case ParameterType::Double: return message.double_value;
    case ParameterType::String: return message.string_value;
    case ParameterType::ByteArray: return vector_of<std::uint8_t>(message.byte_array_value);
    case ParameterType::BoolArray: return vector_of<bool>(message.bool_array_value);
    case ParameterType::IntegerArray: return vector_of<std::int64_t>(message.integer_array_value);
    case ParameterType::DoubleArray: return vector_of<double>(message.double_array_value);
    case ParameterType::StringArray: return vector_of<std::string>(message.string_array_value);
  }
  throw std::invalid_argument("parameter " + name + ": there is no type " + std::to_string(message.type) +
                              " (rcl_interfaces/msg/ParameterType has 0 to 9)");
}

rcl_interfaces::msg::ParameterValue message_of(const ParameterValue& value) {
  rcl_interfaces::msg::ParameterValue message;
  message.type = static_cast<std::uint8_t>(type_of(value));
  std::visit(Fill{message}, value);
  return message;
}

rcl_interfaces::msg::Parameter message_of(const Parameter& parameter) {
  rcl_interfaces::msg::Parameter message;
  message.name = parameter.get_name();
  message.value = message_of(parameter.get_parameter_value());
  return message;
}

rcl_interfaces::msg::ParameterDescriptor descriptor_of(const ParameterReport& parameter) {
  const ParameterDescriptor& descriptor = parameter.descriptor;
  rcl_interfaces::msg::ParameterDescriptor message;
  message.name = parameter.name;
  message.type = static_cast<std::uint8_t>(descriptor.dynamic_typing ? type_of(parameter.value) : parameter.type);
  message.description = descriptor.description;
  message.additional_constraints = descriptor.additional_constraints;
  message.read_only = descriptor.read_only;
  message.dynamic_typing = descriptor.dynamic_typing;
  if (const auto& range = descriptor.integer_range) {
    message.integer_range.emplace_back();
    message.integer_range.back().from_value = range->from;
    message.integer_range.back().to_value = range->to;
    message.integer_range.back().step = range->step;
  }
  if (const auto& range = descriptor.floating_point_range) {
    message.floating_point_range.emplace_back();
    message.floating_point_range.back().from_value = range->from;
    message.floating_point_range.back().to_value = range->to;
    message.floating_point_range.back().step = range->step;
  }
  return message;
}

}  // namespace nacelle::runtime
