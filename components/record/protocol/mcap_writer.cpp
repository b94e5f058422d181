// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/mcap_writer.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "record/protocol/mcap_codec.hpp"

namespace nacelle::record {

namespace {

constexpr std::size_t kIndexRoom = std::size_t{64}
                                   << 10U;  // of some hundred chunks; a bag of hours has it grow a few times

void set_number(Bytes& bytes, std::size_t at, std::uint64_t number) {
  for (std::size_t byte = 0; byte < sizeof number; ++byte)
    bytes[at + byte] = static_cast<std::uint8_t>(number >> (8 * byte));
}

/// Returns where the next one goes.
template <class Number>
std::uint8_t* put_number(std::uint8_t* to, Number number) {
  for (std::size_t byte = 0; byte < sizeof number; ++byte) to[byte] = static_cast<std::uint8_t>(number >> (8 * byte));
  return to + sizeof number;
}

}  // namespace

McapWriter::McapWriter(ByteSink& sink, McapWriterOptions options)
    : sink_(sink),
      options_(std::move(options)),
      compressor_(options_.compression),
      chunk_(options_.chunk_bytes + options_.chunk_bytes / 8) {
  chunk_indexes_.reserve(std::min(options_.chunk_bytes, kIndexRoom));
}

void McapWriter::note_written(ByteView bytes) {
  written_ += bytes.size();
  if (options_.data_crc) data_crc_ = crc32_of(bytes, data_crc_);
}

bool McapWriter::put(ByteView bytes) {
  if (closed_) return false;
  closed_ = !sink_.write(bytes);
  if (!closed_) note_written(bytes);
  return !closed_;
}

bool McapWriter::hand_over(ByteBuffer& buffer) {
  if (closed_) return false;
  note_written(std::as_const(buffer).bytes());
  closed_ = !sink_.hand_over(buffer);
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
  chunk_indexes_.clear();
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

void McapWriter::begin_chunk() {
  if (chunk_.size() > 0) return;
  static_cast<void>(chunk_.extend(kChunkHead));
  checked_ = kChunkHead;
  chunk_crc_ = 0;
}

void McapWriter::introduce(Channel& channel) {
  if (channel.is_written) return;
  channel.is_written = true;
  scratch_.clear();
  if (channel.record.schema_id > 0) {
    Schema& schema = schemas_[channel.record.schema_id - 1];
    if (!schema.is_written)
      append_record(McapSchema{channel.record.schema_id, schema.name, schema.encoding, {as_bytes(schema.text)}},
                    scratch_);
    schema.is_written = true;
  }
  append_record(channel.record, scratch_);
  chunk_.append(scratch_);
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
  begin_chunk();
  introduce(channel);
  channel.index.entries.emplace_back(message.log_time, chunk_.size() - kChunkHead);
  note_time(message.log_time);
  ++channel.messages;
  ++chunk_messages_;
  ++statistics_.message_count;
  constexpr std::size_t kFields = 2 + 4 + 8 + 8;
  std::uint8_t* to = chunk_.extend(kMcapRecordHead + kFields + size).data();
  to = put_number(to, static_cast<std::uint8_t>(McapOpcode::Message));
  to = put_number(to, std::uint64_t{kFields + size});
  to = put_number(to, message.channel_id);
  to = put_number(to, message.sequence);
  to = put_number(to, message.log_time);
  put_number(to, message.publish_time);
  return true;
}

bool McapWriter::end_message() {
  const ByteView unchecked = std::as_const(chunk_).bytes().subspan(checked_);
  chunk_crc_ = crc32_of(unchecked, chunk_crc_);
  checked_ += unchecked.size();
  return pending() < options_.chunk_bytes || close_chunk();
}

bool McapWriter::write(const McapMessage& message) {
  return write(message, message.data.bytes.size(), [&](ByteSpan to) {
    if (!to.empty()) std::memcpy(to.data(), message.data.bytes.data(), to.size());
  });
}

bool McapWriter::close_chunk() {
  if (closed_) return false;
  if (pending() == 0) return true;
  const ByteView records = std::as_const(chunk_).bytes().subspan(kChunkHead);
  McapChunk chunk{chunk_begin_, chunk_end_, records.size(), chunk_crc_, mcap_name(options_.compression), {}};
  bool is_packed = options_.compression != Compression::None;
  if (is_packed) {
    packed_.resize(kChunkHead + chunk.compression.size());
    is_packed = compressor_.append(records, packed_);
  }
  if (!is_packed) chunk.compression.clear();
  const std::size_t head = kChunkHead + chunk.compression.size();
  const std::size_t length = is_packed ? packed_.size() : chunk_.size();
  index_.message_start_time = chunk_begin_;
  index_.message_end_time = chunk_end_;
  index_.chunk_start_offset = written_;
  index_.chunk_length = length;
  index_.compression = chunk.compression;
  index_.compressed_size = length - head;
  index_.uncompressed_size = chunk.uncompressed_size;

  // Head, records and indexes go out as one.
  scratch_.clear();
  append_record(chunk, scratch_);
  set_number(scratch_, 1, length - kMcapRecordHead);
  set_number(scratch_, head - sizeof(std::uint64_t), length - head);
  std::memcpy(is_packed ? packed_.data() : chunk_.bytes().data(), scratch_.data(), head);
  scratch_.clear();
  index_.message_index_offsets.clear();
  for (Channel& channel : channels_) {
    if (channel.index.entries.empty()) continue;
    index_.message_index_offsets.emplace_back(channel.record.id, written_ + length + scratch_.size());
    append_record(channel.index, scratch_);
    channel.index.entries.clear();
  }
  index_.message_index_length = scratch_.size();
  append_record(index_, chunk_indexes_);
  chunk_messages_ = 0;
  ++statistics_.chunk_count;
  if (!is_packed) {
    chunk_.append(scratch_);
    return hand_over(chunk_);
  }
  packed_.insert(packed_.end(), scratch_.begin(), scratch_.end());
  chunk_.clear();
  return put(packed_);
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
  group(McapOpcode::ChunkIndex, [&] { out.insert(out.end(), chunk_indexes_.begin(), chunk_indexes_.end()); });
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
