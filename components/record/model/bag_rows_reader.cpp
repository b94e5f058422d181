// SPDX-License-Identifier: Apache-2.0
#include "record/model/bag_rows_reader.hpp"

#include <utility>

namespace nacelle::record {

bool BagRowsReader::end(McapFault fault, const char* what) {
  visitor_.on_problem({fault, row_, what});
  has_ended_ = true;
  return false;
}

bool BagRowsReader::next() {
  if (has_ended_) return false;
  if (!has_begun_) {
    has_begun_ = true;
    rows_.rewind();
    introduce();
  }
  BagMessage message;
  switch (rows_.next(message)) {
    case BagRows::Step::Row: hand_over(message); return true;
    case BagRows::Step::End: is_complete_ = has_ended_ = true; return false;
    case BagRows::Step::Damaged: return end(McapFault::Truncated, "the database is damaged behind this row");
    case BagRows::Step::TooLarge: return end(McapFault::TooLarge, "the message behind this row is too large");
    case BagRows::Step::Unreadable: break;
  }
  return end(McapFault::Unreadable, "what is behind this row cannot be read");
}

void BagRowsReader::introduce() {
  visitor_.on_header({"ros2", "rosbag2_storage_sqlite3"});
  for (const BagDefinition& definition : rows_.definitions()) definitions_.try_emplace(definition.type, &definition);
  std::uint16_t id = 0;
  for (const BagRowTopic& topic : rows_.topics()) {
    McapChannel channel{++id, schema_of(topic.type), topic.name, topic.format, {}};
    if (!topic.qos_profiles.empty()) channel.metadata["offered_qos_profiles"] = topic.qos_profiles;
    if (!topic.type_hash.empty()) channel.metadata["topic_type_hash"] = topic.type_hash;
    channels_[topic.id] = id;
    visitor_.on_channel(channel);
  }
}

std::uint16_t BagRowsReader::schema_of(const std::string& type) {
  const auto [known, is_new] = schemas_.try_emplace(type, static_cast<std::uint16_t>(schemas_.size() + 1));
  if (!is_new) return known->second;
  std::string encoding, text;
  if (const auto found = definitions_.find(type); found != definitions_.end()) {
    encoding = found->second->encoding;
    text = found->second->text;
  } else if (auto other = definition_ ? definition_(type) : std::nullopt) {
    encoding = "ros2msg";
    text = std::move(*other);
  }
  visitor_.on_schema({known->second, type, encoding, {as_bytes(text)}});
  return known->second;
}

void BagRowsReader::hand_over(const BagMessage& message) {
  row_ = static_cast<std::uint64_t>(message.row);
  if (!message.topic_id || !message.time || *message.time < 0 || !message.data)
    return visitor_.on_problem({McapFault::BadRecord, row_, "a message has no topic, no time or no bytes"});
  const auto channel = channels_.find(*message.topic_id);
  if (channel == channels_.end())
    return visitor_.on_problem({McapFault::UnknownChannel, row_, "a message of a topic that the file does not name"});
  const auto at = static_cast<std::uint64_t>(*message.time);
  visitor_.on_message({channel->second, 0, at, at, {*message.data}}, {row_, message.data->size(), 0});
}

}  // namespace nacelle::record
