// SPDX-License-Identifier: Apache-2.0
#include "record/component/message_log.hpp"

#include <algorithm>
#include <utility>

#include "nacelle/msgs/byte_message.hpp"

namespace nacelle::record {

std::size_t MessageLog::add_topic(const std::string& name, const msgs::MessageType& type, std::vector<QoS> offered) {
  const auto known = std::find_if(topics_.begin(), topics_.end(),
                                  [&](const Topic& topic) { return topic.type == &type && topic.known.name == name; });
  if (known != topics_.end()) return static_cast<std::size_t>(known - topics_.begin());
  topics_.push_back({{name, type.name, type.hash, std::move(offered)}, &type});
  return topics_.size() - 1;
}

void MessageLog::count(Topic& topic, std::size_t size) {
  ++messages_;
  ++topic.known.messages;
  topic.bytes += size;
}

std::optional<std::uint16_t> channel_of(const MessageLog::Topic& topic, McapWriter& writer) {
  // Without a definition there is no encoding of one, as with rosbag2.
  const std::string definition = topic.type->definition;
  const bool is_unknown = definition.empty() && msgs::is_byte_type(*topic.type);
  const auto schema = writer.add_schema(topic.known.type, is_unknown ? "" : "ros2msg", definition);
  if (!schema) return std::nullopt;
  return writer.add_channel(
      *schema, topic.known.name, "cdr",
      {{"offered_qos_profiles", offered_qos_profiles(topic.known.offered)}, {"topic_type_hash", topic.known.hash}});
}

bool write_attachment(const RunText& text, std::uint64_t time, McapWriter& writer) {
  McapAttachment attachment{time, time, text.name, text.media_type};
  attachment.data.bytes = as_bytes(text.text);
  return writer.write_attachment(attachment);
}

}  // namespace nacelle::record
