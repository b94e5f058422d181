// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_copy.hpp"

namespace nacelle::record {

void RecordingCopy::on_schema(const McapSchema& schema) {
  const auto id = writer_.add_schema(schema.name, schema.encoding, std::string{as_text(schema.data.bytes)});
  expect(id.has_value());
  if (id) schemas_[schema.id] = *id;
}

void RecordingCopy::on_channel(const McapChannel& channel) {
  const std::uint16_t schema = channel.schema_id == 0 ? std::uint16_t{0} : schemas_[channel.schema_id];
  const auto id = writer_.add_channel(schema, channel.topic, channel.message_encoding, channel.metadata);
  expect(id.has_value());
  if (id) channels_[channel.id] = *id;
}

void RecordingCopy::on_message(const McapMessage& message, const McapSpot&) {
  const auto channel = channels_.find(message.channel_id);
  if (channel == channels_.end()) return;
  McapMessage copy = message;
  copy.channel_id = channel->second;
  const bool done = writer_.write(copy);
  expect(done);
  if (done) ++messages_;
}

void RecordingCopy::on_chunk(const McapChunk&, const McapSpot&) { expect(writer_.close_chunk()); }

void RecordingCopy::on_attachment(const McapAttachment& attachment, const McapSpot&) {
  expect(writer_.write_attachment(attachment));
}

void RecordingCopy::on_metadata(const McapMetadata& metadata, const McapSpot&) {
  expect(writer_.write_metadata(metadata));
}

}  // namespace nacelle::record
