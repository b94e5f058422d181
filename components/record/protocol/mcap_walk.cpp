// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/mcap_walk.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>

#include "record/protocol/compression.hpp"
#include "record/protocol/mcap_codec.hpp"

namespace nacelle::record {
namespace {

std::uint64_t length_of(ByteView head) {
  std::uint64_t length = 0;
  for (std::size_t byte = 0; byte < 8; ++byte) length |= std::uint64_t{head[1 + byte]} << (8 * byte);
  return length;
}

}  // namespace

class McapParts::Walk final : public RecordingReader {
 public:
  Walk(ByteSource& source, McapVisitor& visitor) : source_(source), visitor_(visitor), size_(source.size()) {}

  bool next() override {
    if (has_ended_) return false;
    has_ended_ = !step();
    return !has_ended_;
  }
  [[nodiscard]] bool is_complete() const override { return is_complete_; }

  bool read_summary() {
    constexpr std::uint64_t kEnd = kMcapRecordHead + 8 + 8 + 4 + sizeof kMcapMagic;
    if (!has_magic(0)) return stop(McapFault::NoMagic, "it does not begin as an MCAP file");
    if (size_ < kEnd) return stop(size_, McapFault::Truncated, "it has no footer: the writer did not finish it");
    std::uint64_t at = size_ - kEnd;
    std::uint8_t head[kMcapRecordHead];
    if (!has_magic(size_ - sizeof kMcapMagic) || !source_.read_at(at, head) ||
        static_cast<McapOpcode>(head[0]) != McapOpcode::Footer ||
        length_of(head) != kEnd - kMcapRecordHead - sizeof kMcapMagic)
      return stop(at, McapFault::Truncated, "it has no footer: the writer did not finish it");
    const std::uint64_t footer_at = at;
    if (!record(at, size_)) return false;
    const auto footer = decode_record<McapFooter>(content_);
    if (!footer || footer->summary_start > footer_at)
      return stop(footer_at, McapFault::BadRecord, "the footer names a summary behind it");
    visitor_.on_footer(*footer, spot_);
    if (footer->summary_start == 0) return true;
    if (footer->summary_crc != 0) {
      const std::uint64_t length = footer_at + kMcapRecordHead + 8 + 8 - footer->summary_start;
      if (length > kMostMcapRecordBytes) return stop(footer_at, McapFault::TooLarge, "the summary has more than 1 GiB");
      Bytes summary(length);
      if (!source_.read_at(footer->summary_start, summary))
        return stop(footer->summary_start, McapFault::Unreadable, "reading failed");
      if (crc32_of(summary) != footer->summary_crc)
        return stop(footer->summary_start, McapFault::BadCrc, "the summary's CRC does not match");
    }
    const std::uint64_t limit =
        footer->summary_offset_start > footer->summary_start ? footer->summary_offset_start : footer_at;
    if (limit > footer_at) return stop(footer_at, McapFault::BadRecord, "the summary reaches beyond the footer");
    return read(footer->summary_start, limit - footer->summary_start);
  }

  bool read(std::uint64_t offset, std::uint64_t length) {
    if (offset > size_ || length > size_ - offset)
      return stop(offset, McapFault::Truncated, "an index names what is beyond the end of the file");
    const std::uint64_t limit = offset + length;
    for (std::uint64_t at = offset; at < limit;) {
      if (!record(at, limit)) return false;
    }
    return true;
  }

 private:
  /// Hands over the record at at_. False if it was the last one, or a problem ends the walk.
  bool step() {
    if (at_ == 0) {
      if (!has_magic(0)) return stop(McapFault::NoMagic, "it does not begin as an MCAP file");
      at_ = sizeof kMcapMagic;
    }
    if (at_ >= size_) return stop(at_, McapFault::Truncated, "it has no footer: the writer did not finish it");
    const auto opcode = record(at_, size_);
    if (opcode == McapOpcode::Footer) is_complete_ = end(at_);
    return opcode && *opcode != McapOpcode::Footer;
  }
  /// Hands the record at `at` over, if it is no footer, and goes behind it. Nothing: the rest up to `limit` cannot be read.
  std::optional<McapOpcode> record(std::uint64_t& at, std::uint64_t limit) {
    const auto fail = [&](McapFault fault, const char* what) {
      stop(at, fault, what);
      return std::nullopt;
    };
    if (limit - at < kMcapRecordHead) return fail(McapFault::Truncated, "it ends inside the head of a record");
    std::uint8_t head[kMcapRecordHead];
    if (!source_.read_at(at, head)) return fail(McapFault::Unreadable, "reading failed");
    const std::uint64_t length = length_of(head);
    if (length > limit - at - kMcapRecordHead) return fail(McapFault::Truncated, "it ends inside a record");
    if (length > kMostMcapRecordBytes) return fail(McapFault::TooLarge, "a record has more than 1 GiB");
    content_.resize(length);
    if (!source_.read_at(at + kMcapRecordHead, content_)) return fail(McapFault::Unreadable, "reading failed");
    const auto opcode = static_cast<McapOpcode>(head[0]);
    spot_ = {at, kMcapRecordHead + length, 0};
    at += spot_.length;
    if (opcode != McapOpcode::Footer && !top_level(opcode))
      tell(McapFault::BadRecord, "a field reaches beyond its record");
    return opcode;
  }
  bool has_magic(std::uint64_t at) {
    std::uint8_t magic[sizeof kMcapMagic];
    return size_ >= sizeof magic && at <= size_ - sizeof magic && source_.read_at(at, magic) &&
           std::memcmp(magic, kMcapMagic, sizeof magic) == 0;
  }
  void tell(McapFault fault, const char* what) { visitor_.on_problem({fault, spot_.offset, what}); }
  bool stop(std::uint64_t at, McapFault fault, const char* what) {
    visitor_.on_problem({fault, at, what});
    return false;
  }
  bool stop(McapFault fault, const char* what) { return stop(0, fault, what); }

  bool end(std::uint64_t at) {
    const auto footer = decode_record<McapFooter>(content_);
    if (!footer) return stop(spot_.offset, McapFault::BadRecord, "the footer is too short");
    visitor_.on_footer(*footer, spot_);
    if (!has_magic(at)) return stop(at, McapFault::Truncated, "no magic follows the footer");
    if (at + sizeof kMcapMagic != size_) return stop(at, McapFault::BadRecord, "something follows the end of the file");
    return true;
  }

  /// Decodes a record and hands it to a function of the visitor. False if a field reaches beyond it.
  template <class Record, class... Spot>
  bool hand(void (McapVisitor::*to)(const Record&, Spot...), Spot... spot) {
    const auto record = decode_record<Record>(content_);
    if (record) (visitor_.*to)(*record, spot...);
    return record.has_value();
  }

  bool top_level(McapOpcode opcode) {
    using V = McapVisitor;
    switch (opcode) {
      case McapOpcode::Header: return hand<McapHeader>(&V::on_header);
      case McapOpcode::Schema:
      case McapOpcode::Channel:
      case McapOpcode::Message: return inner(opcode, content_);
      case McapOpcode::Chunk: return chunk();
      case McapOpcode::MessageIndex: return hand<McapMessageIndex, const McapSpot&>(&V::on_message_index, spot_);
      case McapOpcode::ChunkIndex: return hand<McapChunkIndex>(&V::on_chunk_index);
      case McapOpcode::Attachment: return attachment();
      case McapOpcode::AttachmentIndex: return hand<McapAttachmentIndex>(&V::on_attachment_index);
      case McapOpcode::Statistics: return hand<McapStatistics>(&V::on_statistics);
      case McapOpcode::Metadata: return hand<McapMetadata, const McapSpot&>(&V::on_metadata, spot_);
      case McapOpcode::MetadataIndex: return hand<McapMetadataIndex>(&V::on_metadata_index);
      case McapOpcode::SummaryOffset: return hand<McapSummaryOffset>(&V::on_summary_offset);
      case McapOpcode::DataEnd: return hand<McapDataEnd, const McapSpot&>(&V::on_data_end, spot_);
      case McapOpcode::Footer: break;
    }
    if (opcode == McapOpcode{0}) tell(McapFault::BadRecord, "an opcode is 0");
    return true;  // an opcode that the specification does not name is skipped
  }

  bool attachment() {
    const auto record = decode_record<McapAttachment>(content_);
    if (!record) return false;
    if (record->crc != 0) {
      Bytes& again = unpacked_;
      again.clear();
      append_record(*record, again);
      if (crc32_of(ByteView{again}.subspan(kMcapRecordHead, again.size() - kMcapRecordHead - 4)) != record->crc)
        tell(McapFault::BadCrc, "an attachment's CRC does not match");
    }
    visitor_.on_attachment(*record, spot_);
    return true;
  }

  bool chunk() {
    const auto record = decode_record<McapChunk>(content_);
    if (!record) return false;
    visitor_.on_chunk(*record, spot_);
    const auto compression = compression_of(record->compression);
    if (!compression) {
      tell(McapFault::UnknownCompression, "a chunk's compression is none of '', 'lz4' and 'zstd'");
      return true;
    }
    if (record->uncompressed_size > kMostMcapRecordBytes) {
      tell(McapFault::TooLarge, "a chunk has more than 1 GiB uncompressed");
      return true;
    }
    ByteView records = record->records.bytes;
    if (*compression == Compression::None) {
      if (records.size() != record->uncompressed_size)
        tell(McapFault::BadCompression, "a chunk has another size than it states");
    } else {
      if (!uncompress(*compression, records, record->uncompressed_size, unpacked_)) {
        tell(McapFault::BadCompression, "a chunk cannot be uncompressed to the size that it states");
        return true;
      }
      records = unpacked_;
    }
    if (record->uncompressed_crc != 0 && crc32_of(records) != record->uncompressed_crc) {
      tell(McapFault::BadCrc, "a chunk's CRC does not match");
      return true;
    }
    walk_inside(records);
    return true;
  }

  void walk_inside(ByteView records) {
    const McapSpot of_chunk = spot_;
    for (std::size_t at = 0; at < records.size();) {
      const ByteView rest = records.subspan(at);
      const std::uint64_t length = rest.size() < kMcapRecordHead ? 0 : length_of(rest);
      if (rest.size() < kMcapRecordHead || length > rest.size() - kMcapRecordHead) {
        tell(McapFault::BadRecord, "a record reaches beyond its chunk");
        break;
      }
      spot_ = {of_chunk.offset, kMcapRecordHead + length, at};
      if (!inner(static_cast<McapOpcode>(rest[0]), rest.subspan(kMcapRecordHead, length)))
        tell(McapFault::BadRecord, "a field reaches beyond its record");
      at += spot_.length;
    }
    spot_ = of_chunk;
  }

  /// Of a schema, a channel or a message.
  bool inner(McapOpcode opcode, ByteView content) {
    if (opcode == McapOpcode::Schema) return schema(content);
    if (opcode == McapOpcode::Channel) return channel(content);
    if (opcode != McapOpcode::Message) {
      if (opcode <= McapOpcode::DataEnd) tell(McapFault::BadRecord, "a chunk has a record that may not stand in one");
      return true;
    }
    const auto message = decode_record<McapMessage>(content);
    if (!message) return false;
    if (channels_.count(message->channel_id) == 0) {
      tell(McapFault::UnknownChannel, "a message of a channel that no record before it describes");
    } else {
      visitor_.on_message(*message, spot_);
    }
    return true;
  }

  bool schema(ByteView content) {
    const auto record = decode_record<McapSchema>(content);
    if (!record) return false;
    if (record->id == 0) {
      tell(McapFault::BadRecord, "a schema has the id 0");
      return true;
    }
    if (is_new(schemas_[record->id], content, "two schemas have one id")) visitor_.on_schema(*record);
    return true;
  }
  bool channel(ByteView content) {
    const auto record = decode_record<McapChannel>(content);
    if (!record) return false;
    if (record->schema_id != 0 && schemas_.count(record->schema_id) == 0) {
      tell(McapFault::UnknownChannel, "a channel of a schema that no record before it describes");
      return true;
    }
    if (is_new(channels_[record->id], content, "two channels have one id")) visitor_.on_channel(*record);
    return true;
  }
  /// `known`: what the same id had before; empty: nothing.
  bool is_new(Bytes& known, ByteView content, const char* conflict) {
    if (known.empty()) {
      known.assign(content.begin(), content.end());
      return true;
    }
    if (!std::equal(known.begin(), known.end(), content.begin(), content.end())) tell(McapFault::Conflict, conflict);
    return false;
  }

  ByteSource& source_;
  McapVisitor& visitor_;
  const std::uint64_t size_;
  McapSpot spot_;
  Bytes content_, unpacked_;
  std::map<std::uint16_t, Bytes> schemas_, channels_;
  std::uint64_t at_ = 0;  // of next()
  bool has_ended_ = false, is_complete_ = false;
};

std::unique_ptr<RecordingReader> read_mcap(ByteSource& source, McapVisitor& visitor) {
  return std::unique_ptr<RecordingReader>{new McapParts::Walk{source, visitor}};
}

bool walk_mcap(ByteSource& source, McapVisitor& visitor) {
  McapParts::Walk walk{source, visitor};
  while (walk.next()) {}
  return walk.is_complete();
}

McapParts::McapParts(ByteSource& source, McapVisitor& visitor) : walk_(std::make_unique<Walk>(source, visitor)) {}
McapParts::~McapParts() = default;
bool McapParts::read_summary() { return walk_->read_summary(); }
bool McapParts::read(std::uint64_t offset, std::uint64_t length) { return walk_->read(offset, length); }

}  // namespace nacelle::record
