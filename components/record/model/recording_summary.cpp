// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_summary.hpp"

#include <algorithm>

#include "nacelle/base/problem.hpp"

namespace nacelle::record {

double RecordedTopic::rate_hz() const {
  if (messages < 2 || last <= first) return 0.0;
  return static_cast<double>(messages - 1) / (static_cast<double>(last - first) * 1e-9);
}

std::string RecordingSummary::compression() const {
  std::vector<std::string> names;
  for (const auto& [name, count] : compressions_) names.push_back(name.empty() ? "none" : name);
  return names.empty() ? "none" : join(names);
}

void RecordingSummary::on_header(const McapHeader& header) {
  profile_ = header.profile;
  library_ = header.library;
}

// A type without fields has an encoding, and an empty text.
void RecordingSummary::on_schema(const McapSchema& schema) {
  types_[schema.id] = schema.name;
  if (schema.encoding.empty()) undefined_.insert(schema.id);
}

void RecordingSummary::on_channel(const McapChannel& channel) {
  RecordedTopic& topic = topics_[channel.id];
  topic.name = channel.topic;
  topic.type = channel.schema_id == 0 ? "" : types_[channel.schema_id];
  topic.has_definition = channel.schema_id != 0 && !undefined_.contains(channel.schema_id);
  topic.encoding = channel.message_encoding;
  topic.metadata = channel.metadata;
}

void RecordingSummary::on_message(const McapMessage& message, const McapSpot& spot) {
  const std::uint64_t at = message.log_time;
  if (spot.offset != piece_) {
    piece_ = spot.offset;
    last_before_piece_ = last_;
  }
  if (at < last_before_piece_) disorder_ = std::max(disorder_, last_before_piece_ - at);
  const bool is_first = messages_ == 0;
  ++messages_;
  first_ = is_first ? at : std::min(first_, at);
  last_ = is_first ? at : std::max(last_, at);
  RecordedTopic& topic = topics_[message.channel_id];
  if (topic.messages == 0) {
    topic.first = topic.last = at;
  } else if (at > topic.last && at - topic.last > topic.longest_gap) {
    topic.longest_gap = at - topic.last;
    topic.gap_at = topic.last;
  }
  topic.first = std::min(topic.first, at);
  topic.last = std::max(topic.last, at);
  topic.bytes += message.data.bytes.size();
  ++topic.messages;
}

void RecordingSummary::on_chunk(const McapChunk& chunk, const McapSpot&) {
  ++chunks_;
  ++compressions_[chunk.compression];
}

void RecordingSummary::on_attachment(const McapAttachment& attachment, const McapSpot&) {
  attachments_.push_back({attachment.name, attachment.media_type, attachment.data.bytes.size()});
}

void RecordingSummary::on_metadata(const McapMetadata& metadata, const McapSpot&) {
  metadata_[metadata.name] = metadata.metadata;
}

}  // namespace nacelle::record
