// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "record/protocol/mcap_walk.hpp"

namespace nacelle::record {

/// What can be said of a message's bytes.
enum class PayloadVerdict : std::uint8_t { Good, Bad, UnknownType };
/// Looks at the bytes of a message of this type ("sensor_msgs/msg/LaserScan") in this encoding ("cdr").
using PayloadCheck =
    std::function<PayloadVerdict(const std::string& type, const std::string& encoding, ByteView bytes)>;

/// Compares what a recording says of itself with what it has: checksums, indexes, counts, times, and the bytes of its messages.
///
/// Threads: one. Allocates: an index of the chunk at hand, and what the summary repeats.
class RecordingCheck final : private McapVisitor {
 public:
  struct Report {
    std::vector<McapProblem> problems;  ///< The first ones, at most kMostProblems.
    std::uint64_t problem_count = 0;    ///< All of them.
    std::uint64_t messages = 0, chunks = 0, attachments = 0;
    std::uint64_t checksums = 0;                  ///< Those that were there, and compared.
    std::uint64_t indexed = 0;                    ///< Messages that an index leads to.
    std::map<std::string, std::uint64_t> unread;  ///< Messages of types that the payload check does not know, by type.
    bool complete = false;                        ///< The walk reached the end.
  };
  static constexpr std::size_t kMostProblems = 100;

  RecordingCheck(ByteSource& source, PayloadCheck payload) : source_(source), payload_(std::move(payload)) {}
  /// Reads the whole file.
  [[nodiscard]] Report run();

 private:
  using Index = std::vector<std::pair<std::uint64_t, std::uint64_t>>;
  struct SeenChunk {
    McapChunk chunk;  // without its records
    std::uint64_t length = 0;
    std::map<std::uint16_t, std::uint64_t> message_index_offsets;
    std::uint64_t message_index_length = 0;
  };
  struct Channel {
    std::string type, encoding;
    std::uint64_t messages = 0;
  };

  void on_header(const McapHeader&) override { has_header_ = true; }
  void on_schema(const McapSchema& schema) override;
  void on_channel(const McapChannel& channel) override;
  void on_message(const McapMessage& message, const McapSpot& spot) override;
  void on_chunk(const McapChunk& chunk, const McapSpot& spot) override;
  void on_message_index(const McapMessageIndex& index, const McapSpot& spot) override;
  void on_attachment(const McapAttachment& attachment, const McapSpot& spot) override;
  void on_metadata(const McapMetadata& metadata, const McapSpot& spot) override;
  void on_chunk_index(const McapChunkIndex& index) override;
  void on_attachment_index(const McapAttachmentIndex& index) override;
  void on_metadata_index(const McapMetadataIndex& index) override;
  void on_statistics(const McapStatistics& statistics) override;
  void on_summary_offset(const McapSummaryOffset& offset) override;
  void on_data_end(const McapDataEnd& end, const McapSpot& spot) override;
  void on_footer(const McapFooter& footer, const McapSpot& spot) override;
  void on_problem(const McapProblem& problem) override;

  void tell(McapFault fault, std::uint64_t offset, const char* what) { on_problem({fault, offset, what}); }
  /// Compares the messages of the last chunk with its indexes.
  void end_chunk();
  void check_crc(std::uint32_t stated, std::uint64_t begin, std::uint64_t end, const char* what);

  ByteSource& source_;
  const PayloadCheck payload_;
  Report report_;
  std::map<std::uint16_t, std::string> types_;  // of schemas
  std::map<std::uint16_t, Channel> channels_;
  std::map<std::uint64_t, SeenChunk> chunks_;                                              // by offset
  std::map<std::uint64_t, std::pair<std::uint64_t, std::string>> attachments_, metadata_;  // offset: length, name
  std::set<std::uint64_t> indexed_chunks_;
  std::map<std::uint16_t, Index> in_chunk_, of_index_;
  bool has_header_ = false, has_data_end_ = false;
  bool has_index_ = false, chunk_is_open_ = false;
  std::uint64_t chunk_at_ = 0, schemas_ = 0;
  std::uint64_t first_ = 0, last_ = 0;
  std::vector<McapSummaryOffset> groups_;
};

}  // namespace nacelle::record
