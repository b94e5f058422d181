// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "record/model/byte_file.hpp"
#include "record/protocol/compression.hpp"
#include "record/protocol/mcap_records.hpp"

namespace nacelle::record {

struct McapWriterOptions {
  Compression compression = Compression::None;
  std::size_t chunk_bytes = std::size_t{1} << 20U;  ///< A chunk is closed by the message that reaches this size.
  bool data_crc = false;  ///< A checksum of all that is before the summary, beside those of chunks and of the summary.
  std::string profile = "ros2";
  std::string library = "nacelle";
};

/// Writes one MCAP file: messages in chunks with their indexes, a summary at the end.
///
/// What was closed (close_chunk) is readable although the rest is lost. After a failed write of the sink all functions return false or
/// nullopt, and nothing more is written.
/// Threads: one. Allocates: for new schemas, channels and chunks; nothing for a message once chunks have had their size.
class McapWriter {
 public:
  McapWriter(ByteSink& sink, McapWriterOptions options);

  /// Writes the magic and the header.
  [[nodiscard]] bool start();
  /// Returns the id of a schema, the same for the same three texts. Errors: nullopt if there are 65,535 already.
  [[nodiscard]] std::optional<std::uint16_t> add_schema(std::string name, std::string encoding, std::string text);
  /// Returns the id of a channel, the same for the same four. Errors: nullopt if there are 65,535 already, or no such schema.
  [[nodiscard]] std::optional<std::uint16_t> add_channel(std::uint16_t schema_id, std::string topic,
                                                         std::string message_encoding,
                                                         std::map<std::string, std::string> metadata);
  /// Adds a message of `size` bytes to the chunk, and hands its bytes to `fill(ByteSpan)`, so that a message is encoded in its place. The
  /// message's own `data` is not read.
  template <class Fill>
  [[nodiscard]] bool write(const McapMessage& message, std::size_t size, Fill&& fill) {
    if (!begin_message(message, size)) return false;
    fill(chunk_.bytes().last(size));
    return end_message();
  }
  [[nodiscard]] bool write(const McapMessage& message);
  /// Writes the messages since the last chunk, if there are any.
  [[nodiscard]] bool close_chunk();
  [[nodiscard]] bool write_attachment(const McapAttachment& attachment);
  [[nodiscard]] bool write_metadata(const McapMetadata& metadata);
  /// Closes the last chunk and writes the summary. Nothing can be written after it.
  [[nodiscard]] bool finish();
  /// Begins another file as start() does, in the same memory and with the same ids of schemas and channels. An open chunk is lost. It mends a
  /// sink that had failed.
  [[nodiscard]] bool start_another();

  /// Bytes handed to the sink so far.
  [[nodiscard]] std::uint64_t written() const { return written_; }
  /// Bytes of messages that wait for their chunk.
  [[nodiscard]] std::size_t pending() const { return chunk_.size() - std::min(chunk_.size(), kChunkHead); }
  [[nodiscard]] std::uint64_t messages() const { return statistics_.message_count; }

 private:
  struct Schema {
    std::string name, encoding, text;
    bool is_written = false;
  };
  struct Channel {
    McapChannel record;
    bool is_written = false;
    McapMessageIndex index;  // of the open chunk
    std::uint64_t messages = 0;
  };

  bool begin_message(const McapMessage& message, std::size_t size);
  bool end_message();
  /// Schema and channel stand in the file before the channel's first message.
  void introduce(Channel& channel);
  void begin_chunk();
  bool put(ByteView bytes);
  bool hand_over(ByteBuffer& buffer);
  void note_written(ByteView bytes);
  void note_time(std::uint64_t time);
  void append_summary(Bytes& out);

  ByteSink& sink_;
  const McapWriterOptions options_;
  Compressor compressor_;
  bool closed_ = false;  // a write failed, or the file is complete
  std::uint64_t written_ = 0;
  std::uint32_t data_crc_ = 0;
  std::vector<Schema> schemas_;    // id - 1
  std::vector<Channel> channels_;  // id - 1
  /// Of a chunk record without compression, before its records.
  static constexpr std::size_t kChunkHead = 1 + 8 + 8 + 8 + 8 + 4 + 4 + 8;
  ByteBuffer chunk_;             // room for the head, then its records
  std::size_t checked_ = 0;      // bytes of chunk_ that are in chunk_crc_
  std::uint32_t chunk_crc_ = 0;  // of the records; computed while they are in the processor's cache
  Bytes scratch_, packed_;
  std::uint64_t chunk_begin_ = 0, chunk_end_ = 0;  // times
  std::size_t chunk_messages_ = 0;
  McapChunkIndexWith<std::vector<std::pair<std::uint16_t, std::uint64_t>>> index_;  // of the last chunk
  Bytes chunk_indexes_;                                                             // records for the summary
  std::vector<McapAttachmentIndex> attachments_;
  std::vector<McapMetadataIndex> metadata_;
  McapStatistics statistics_;
};

}  // namespace nacelle::record
