// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/bytes.hpp"

/// The records of an MCAP file, field by field in their order on disk.
///
/// Numbers are little-endian. Times are nanoseconds since the Unix epoch, offsets count bytes from the start of the file.
/// Source: MCAP specification, https://mcap.dev/spec
namespace nacelle::record {

/// Both ends of a file.
inline constexpr std::uint8_t kMcapMagic[] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
/// An opcode and the length of the content precede each record.
inline constexpr std::size_t kMcapRecordHead = 1 + 8;

enum class McapOpcode : std::uint8_t {
  Header = 0x01,
  Footer = 0x02,
  Schema = 0x03,
  Channel = 0x04,
  Message = 0x05,
  Chunk = 0x06,
  MessageIndex = 0x07,
  ChunkIndex = 0x08,
  Attachment = 0x09,
  AttachmentIndex = 0x0A,
  Statistics = 0x0B,
  Metadata = 0x0C,
  MetadataIndex = 0x0D,
  SummaryOffset = 0x0E,
  DataEnd = 0x0F,
};
/// "Chunk"; "" for an opcode that the specification does not name.
[[nodiscard]] const char* opcode_name(McapOpcode opcode);

/// What a field of bytes says of its length.
struct McapBytes32 {  ///< u32 before it
  ByteView bytes;
};
struct McapBytes64 {  ///< u64 before it
  ByteView bytes;
};
struct McapRest {  ///< nothing: it ends with the record
  ByteView bytes;
};

// `fields(io, record)` hands each field to io in its order: the encoder and the decoder are two such io, and share the layout. Views point
// into the bytes that were decoded.

struct McapHeader {
  static constexpr auto kOpcode = McapOpcode::Header;
  std::string profile, library;
  static void fields(auto& io, auto& r) { io(r.profile, r.library); }
};
struct McapFooter {
  static constexpr auto kOpcode = McapOpcode::Footer;
  std::uint64_t summary_start = 0;         ///< 0: there is no summary.
  std::uint64_t summary_offset_start = 0;  ///< 0: there is none.
  std::uint32_t summary_crc = 0;           ///< From summary_start to this field; 0: not computed.
  static void fields(auto& io, auto& r) { io(r.summary_start, r.summary_offset_start, r.summary_crc); }
};
struct McapSchema {
  static constexpr auto kOpcode = McapOpcode::Schema;
  std::uint16_t id = 0;  ///< Never 0.
  std::string name, encoding;
  McapBytes32 data{};
  static void fields(auto& io, auto& r) { io(r.id, r.name, r.encoding, r.data); }
};
struct McapChannel {
  static constexpr auto kOpcode = McapOpcode::Channel;
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  ///< 0: none.
  std::string topic, message_encoding;
  std::map<std::string, std::string> metadata;
  static void fields(auto& io, auto& r) { io(r.id, r.schema_id, r.topic, r.message_encoding, r.metadata); }
};
struct McapMessage {
  static constexpr auto kOpcode = McapOpcode::Message;
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0, publish_time = 0;
  McapRest data{};
  static void fields(auto& io, auto& r) { io(r.channel_id, r.sequence, r.log_time, r.publish_time, r.data); }
};
struct McapChunk {
  static constexpr auto kOpcode = McapOpcode::Chunk;
  std::uint64_t message_start_time = 0, message_end_time = 0;  ///< 0 in a chunk without messages.
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;  ///< 0: not computed.
  std::string compression;             ///< "", "lz4" or "zstd".
  McapBytes64 records{};
  static void fields(auto& io, auto& r) {
    io(r.message_start_time, r.message_end_time, r.uncompressed_size, r.uncompressed_crc, r.compression, r.records);
  }
};
struct McapMessageIndex {
  static constexpr auto kOpcode = McapOpcode::MessageIndex;
  std::uint16_t channel_id = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> entries;  ///< log_time, offset in the uncompressed chunk.
  static void fields(auto& io, auto& r) { io(r.channel_id, r.entries); }
};
/// `Offsets`: pairs of a channel and an offset.
template <class Offsets>
struct McapChunkIndexWith {
  static constexpr auto kOpcode = McapOpcode::ChunkIndex;
  std::uint64_t message_start_time = 0, message_end_time = 0;
  std::uint64_t chunk_start_offset = 0;
  std::uint64_t chunk_length = 0;  ///< With opcode and length.
  Offsets message_index_offsets;   ///< By channel.
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0, uncompressed_size = 0;
  static void fields(auto& io, auto& r) {
    io(r.message_start_time, r.message_end_time, r.chunk_start_offset, r.chunk_length, r.message_index_offsets,
       r.message_index_length, r.compression, r.compressed_size, r.uncompressed_size);
  }
};
using McapChunkIndex = McapChunkIndexWith<std::map<std::uint16_t, std::uint64_t>>;
struct McapAttachment {
  static constexpr auto kOpcode = McapOpcode::Attachment;
  std::uint64_t log_time = 0, create_time = 0;
  std::string name, media_type;
  McapBytes64 data{};
  std::uint32_t crc = 0;  ///< Of all fields before it; 0: not computed.
  static void fields(auto& io, auto& r) { io(r.log_time, r.create_time, r.name, r.media_type, r.data, r.crc); }
};
struct McapAttachmentIndex {
  static constexpr auto kOpcode = McapOpcode::AttachmentIndex;
  std::uint64_t offset = 0, length = 0, log_time = 0, create_time = 0, data_size = 0;
  std::string name, media_type;
  static void fields(auto& io, auto& r) {
    io(r.offset, r.length, r.log_time, r.create_time, r.data_size, r.name, r.media_type);
  }
};
struct McapStatistics {
  static constexpr auto kOpcode = McapOpcode::Statistics;
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0, attachment_count = 0, metadata_count = 0, chunk_count = 0;
  std::uint64_t message_start_time = 0, message_end_time = 0;
  std::map<std::uint16_t, std::uint64_t> channel_message_counts;
  static void fields(auto& io, auto& r) {
    io(r.message_count, r.schema_count, r.channel_count, r.attachment_count, r.metadata_count, r.chunk_count,
       r.message_start_time, r.message_end_time, r.channel_message_counts);
  }
};
struct McapMetadata {
  static constexpr auto kOpcode = McapOpcode::Metadata;
  std::string name;
  std::map<std::string, std::string> metadata;
  static void fields(auto& io, auto& r) { io(r.name, r.metadata); }
};
struct McapMetadataIndex {
  static constexpr auto kOpcode = McapOpcode::MetadataIndex;
  std::uint64_t offset = 0, length = 0;
  std::string name;
  static void fields(auto& io, auto& r) { io(r.offset, r.length, r.name); }
};
struct McapSummaryOffset {
  static constexpr auto kOpcode = McapOpcode::SummaryOffset;
  std::uint8_t group_opcode = 0;
  std::uint64_t group_start = 0, group_length = 0;
  static void fields(auto& io, auto& r) { io(r.group_opcode, r.group_start, r.group_length); }
};
struct McapDataEnd {
  static constexpr auto kOpcode = McapOpcode::DataEnd;
  std::uint32_t data_section_crc = 0;  ///< From the start of the file; 0: not computed.
  static void fields(auto& io, auto& r) { io(r.data_section_crc); }
};

}  // namespace nacelle::record
