// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_copy.hpp"

namespace nacelle::record {

void RecordingCopy::on_schema(const McapSchema& schema) {
  schemas_[schema.id] = {schema.name, schema.encoding, std::string{as_text(schema.data.bytes)}};
}

void RecordingCopy::on_channel(const McapChannel& channel) {
  if (selection_.wants_topic && !selection_.wants_topic(channel.topic)) return;
  std::uint16_t schema_id = 0;
  if (channel.schema_id != 0) {
    const Schema& schema = schemas_[channel.schema_id];
    const auto added = writer_.add_schema(schema.name, schema.encoding, schema.text);
    expect(added.has_value());
    if (!added) return;
    schema_id = *added;
  }
  const auto id = writer_.add_channel(schema_id, channel.topic, channel.message_encoding, channel.metadata);
  expect(id.has_value());
  if (id) channels_[channel.id] = *id;
}

void RecordingCopy::on_message(const McapMessage& message, const McapSpot&) {
  const auto channel = channels_.find(message.channel_id);
  if (channel == channels_.end() || message.log_time < selection_.from || message.log_time > selection_.to) return;
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
