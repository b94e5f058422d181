// SPDX-License-Identifier: Apache-2.0
#include "record/component/special_topics.hpp"

#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::record {
namespace {

constexpr std::string_view kDescriptionTopic = "/robot_description", kDescriptionType = "std_msgs/msg/String";
constexpr std::string_view kStopTopic = "/emergency_stop", kStopType = "std_msgs/msg/Bool";

}  // namespace

bool is_emergency_stop(const EndpointSpec& spec) {
  return spec.topic.ends_with(kStopTopic) && spec.type->name == kStopType;
}

bool is_description(const EndpointSpec& spec) {
  return spec.topic.ends_with(kDescriptionTopic) && spec.type->name == kDescriptionType;
}

std::string text_in(const msgs::MessageType& type, const void* message) {
  constexpr std::size_t kBegin = 4 + 4;  // after the encapsulation's header and the length; a zero ends it
  Bytes encoded(type.encoded_size(message));
  type.encode(message, encoded.data());
  if (encoded.size() <= kBegin) return {};
  return std::string{as_text(ByteView{encoded}.subspan(kBegin, encoded.size() - kBegin - 1))};
}

bool is_set(const msgs::MessageType& type, const void* message) {
  Bytes encoded(type.encoded_size(message));
  type.encode(message, encoded.data());
  return !encoded.empty() && encoded.back() != 0;
}

}  // namespace nacelle::record
