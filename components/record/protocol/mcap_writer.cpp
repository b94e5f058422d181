// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/mcap_writer.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "record/protocol/mcap_codec.hpp"

namespace nacelle::record {

McapWriter::McapWriter(ByteSink& sink, McapWriterOptions options)
    : sink_(sink), options_(std::move(options)), compressor_(options_.compression) {
  chunk_.reserve(options_.chunk_bytes + options_.chunk_bytes / 8);
}

bool McapWriter::put(ByteView bytes) {
  if (closed_) return false;
  closed_ = !sink_.write(bytes);
  if (!closed_) written_ += bytes.size();
  if (options_.data_crc) data_crc_ = crc32_of(bytes, data_crc_);
  return !closed_;
}

bool McapWriter::start_another() {
  closed_ = false;
  written_ = 0;
  data_crc_ = 0;
  for (Schema& schema : schemas_) schema.is_written = false;
  for (Channel& channel : channels_) {
    channel.is_written = false;
    channel.index.entries.clear();
    channel.messages = 0;
  }
  chunk_.clear();
  chunk_messages_ = 0;
  chunks_.clear();
  attachments_.clear();
  metadata_.clear();
  statistics_ = {};
  return start();
}

bool McapWriter::start() {
  scratch_.assign(std::begin(kMcapMagic), std::end(kMcapMagic));
  append_record(McapHeader{options_.profile, options_.library}, scratch_);
  return put(scratch_);
}

std::optional<std::uint16_t> McapWriter::add_schema(std::string name, std::string encoding, std::string text) {
  const auto same = [&](const Schema& s) { return s.name == name && s.encoding == encoding && s.text == text; };
  const auto found = std::find_if(schemas_.begin(), schemas_.end(), same);
  if (found != schemas_.end()) return static_cast<std::uint16_t>(found - schemas_.begin() + 1);
  if (closed_ || schemas_.size() >= std::numeric_limits<std::uint16_t>::max()) return std::nullopt;
  schemas_.push_back({std::move(name), std::move(encoding), std::move(text)});
  return static_cast<std::uint16_t>(schemas_.size());
}

std::optional<std::uint16_t> McapWriter::add_channel(std::uint16_t schema_id, std::string topic,
                                                     std::string message_encoding,
                                                     std::map<std::string, std::string> metadata) {
  const auto same = [&](const Channel& known) {
    const McapChannel& r = known.record;
    return r.schema_id == schema_id && r.topic == topic && r.message_encoding == message_encoding &&
           r.metadata == metadata;
  };
  const auto found = std::find_if(channels_.begin(), channels_.end(), same);
  if (found != channels_.end()) return found->record.id;
  if (closed_ || channels_.size() >= std::numeric_limits<std::uint16_t>::max() || schema_id > schemas_.size())
    return std::nullopt;
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  Channel channel;
  channel.record = {id, schema_id, std::move(topic), std::move(message_encoding), std::move(metadata)};
  channel.index.channel_id = id;
  channels_.push_back(std::move(channel));
  return id;
}

void McapWriter::introduce(Channel& channel) {
  if (channel.is_written) return;
  channel.is_written = true;
  if (channel.record.schema_id > 0) {
    Schema& schema = schemas_[channel.record.schema_id - 1];
    if (!schema.is_written)
      append_record(McapSchema{channel.record.schema_id, schema.name, schema.encoding, {as_bytes(schema.text)}},
                    chunk_);
    schema.is_written = true;
  }
  append_record(channel.record, chunk_);
}

void McapWriter::note_time(std::uint64_t time) {
  chunk_begin_ = chunk_messages_ == 0 ? time : std::min(chunk_begin_, time);
  chunk_end_ = chunk_messages_ == 0 ? time : std::max(chunk_end_, time);
  auto& whole = statistics_;
  whole.message_start_time = whole.message_count == 0 ? time : std::min(whole.message_start_time, time);
  whole.message_end_time = whole.message_count == 0 ? time : std::max(whole.message_end_time, time);
}

bool McapWriter::begin_message(const McapMessage& message, std::size_t size) {
  if (closed_ || message.channel_id == 0 || message.channel_id > channels_.size()) return false;
  Channel& channel = channels_[message.channel_id - 1];
  introduce(channel);
  channel.index.entries.emplace_back(message.log_time, chunk_.size());
  note_time(message.log_time);
  ++channel.messages;
  ++chunk_messages_;
  ++statistics_.message_count;
  constexpr std::size_t kFields = 2 + 4 + 8 + 8;
  McapEncoder encoder{chunk_};
  encoder(static_cast<std::uint8_t>(McapOpcode::Message), std::uint64_t{kFields + size}, message.channel_id,
          message.sequence, message.log_time, message.publish_time);
  chunk_.resize(chunk_.size() + size);
  return true;
}

bool McapWriter::end_message() { return chunk_.size() < options_.chunk_bytes || close_chunk(); }

bool McapWriter::write(const McapMessage& message) {
  return write(message, message.data.bytes.size(), [&](ByteSpan to) {
    if (!to.empty()) std::memcpy(to.data(), message.data.bytes.data(), to.size());
  });
}

bool McapWriter::close_chunk() {
  if (closed_) return false;
  if (chunk_.empty()) return true;
  McapChunk chunk{chunk_begin_, chunk_end_, chunk_.size(), crc32_of(chunk_), mcap_name(options_.compression), {}};
  ByteView records = chunk_;
  packed_.clear();
  if (options_.compression != Compression::None) {
    if (compressor_.append(chunk_, packed_)) {
      records = packed_;
    } else {
      chunk.compression.clear();
    }
  }
  McapChunkIndex& index = chunks_.emplace_back();
  index.message_start_time = chunk_begin_;
  index.message_end_time = chunk_end_;
  index.chunk_start_offset = written_;
  index.compression = chunk.compression;
  index.compressed_size = records.size();
  index.uncompressed_size = chunk.uncompressed_size;

  // The head without the records, which are written from where they are.
  scratch_.clear();
  append_record(chunk, scratch_);
  McapEncoder{scratch_}(McapRest{});
  index.chunk_length = scratch_.size() + records.size();
  const std::uint64_t content = index.chunk_length - kMcapRecordHead;
  for (std::size_t byte = 0; byte < 8; ++byte) {
    scratch_[1 + byte] = static_cast<std::uint8_t>(content >> (8 * byte));
    scratch_[scratch_.size() - 8 + byte] = static_cast<std::uint8_t>(std::uint64_t{records.size()} >> (8 * byte));
  }
  if (!put(scratch_) || !put(records)) return false;

  scratch_.clear();
  for (Channel& channel : channels_) {
    if (channel.index.entries.empty()) continue;
    index.message_index_offsets[channel.record.id] = written_ + scratch_.size();
    append_record(channel.index, scratch_);
    channel.index.entries.clear();
  }
  index.message_index_length = scratch_.size();
  chunk_.clear();
  chunk_messages_ = 0;
  ++statistics_.chunk_count;
  return put(scratch_);
}

bool McapWriter::write_attachment(const McapAttachment& attachment) {
  if (!close_chunk()) return false;
  McapAttachment with_crc = attachment;
  with_crc.crc = 0;
  scratch_.clear();
  append_record(with_crc, scratch_);
  const ByteView fields = ByteView{scratch_}.subspan(kMcapRecordHead, scratch_.size() - kMcapRecordHead - 4);
  const std::uint32_t crc = crc32_of(fields);
  for (std::size_t byte = 0; byte < 4; ++byte)
    scratch_[scratch_.size() - 4 + byte] = static_cast<std::uint8_t>(crc >> (8 * byte));
  attachments_.push_back({written_, scratch_.size(), attachment.log_time, attachment.create_time,
                          attachment.data.bytes.size(), attachment.name, attachment.media_type});
  ++statistics_.attachment_count;
  return put(scratch_);
}

bool McapWriter::write_metadata(const McapMetadata& metadata) {
  if (!close_chunk()) return false;
  scratch_.clear();
  append_record(metadata, scratch_);
  metadata_.push_back({written_, scratch_.size(), metadata.name});
  ++statistics_.metadata_count;
  return put(scratch_);
}

void McapWriter::append_summary(Bytes& out) {
  const std::uint64_t start = written_ + out.size();
  const std::size_t first = out.size();
  std::vector<McapSummaryOffset> groups;
  const auto group = [&](McapOpcode opcode, auto&& append_all) {
    const std::size_t begin = out.size();
    append_all();
    if (out.size() > begin) groups.push_back({static_cast<std::uint8_t>(opcode), written_ + begin, out.size() - begin});
  };
  group(McapOpcode::Schema, [&] {
    for (std::size_t at = 0; at < schemas_.size(); ++at) {
      const Schema& schema = schemas_[at];
      const auto id = static_cast<std::uint16_t>(at + 1);
      append_record(McapSchema{id, schema.name, schema.encoding, {as_bytes(schema.text)}}, out);
    }
  });
  group(McapOpcode::Channel, [&] {
    for (const Channel& channel : channels_) append_record(channel.record, out);
  });
  group(McapOpcode::Statistics, [&] {
    statistics_.schema_count = static_cast<std::uint16_t>(schemas_.size());
    statistics_.channel_count = static_cast<std::uint32_t>(channels_.size());
    for (const Channel& channel : channels_) {
      if (channel.messages > 0) statistics_.channel_message_counts[channel.record.id] = channel.messages;
    }
    append_record(statistics_, out);
  });
  const auto append_each = [&](const auto& records) {
    for (const auto& record : records) append_record(record, out);
  };
  group(McapOpcode::ChunkIndex, [&] { append_each(chunks_); });
  group(McapOpcode::AttachmentIndex, [&] { append_each(attachments_); });
  group(McapOpcode::MetadataIndex, [&] { append_each(metadata_); });
  const std::uint64_t offsets = written_ + out.size();
  append_each(groups);
  append_record(McapFooter{start, offsets, 0}, out);
  const std::uint32_t crc = crc32_of(ByteView{out}.subspan(first, out.size() - first - 4));
  for (std::size_t byte = 0; byte < 4; ++byte)
    out[out.size() - 4 + byte] = static_cast<std::uint8_t>(crc >> (8 * byte));
}

bool McapWriter::finish() {
  if (!close_chunk()) return false;
  scratch_.clear();
  append_record(McapDataEnd{data_crc_}, scratch_);
  append_summary(scratch_);
  scratch_.insert(scratch_.end(), std::begin(kMcapMagic), std::end(kMcapMagic));
  const bool complete = put(scratch_);
  closed_ = true;
  return complete;
}

}  // namespace nacelle::record
