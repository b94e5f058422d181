// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "record/model/byte_file.hpp"
#include "record/protocol/mcap_fault.hpp"
#include "record/protocol/mcap_records.hpp"

namespace nacelle::record {

/// Where a record stands.
struct McapSpot {
  std::uint64_t offset = 0;    ///< In the file; of a record in a chunk: that of the chunk.
  std::uint64_t length = 0;    ///< With opcode and length; of a record in a chunk: as it is there.
  std::uint64_t in_chunk = 0;  ///< Offset among the uncompressed records of the chunk.
};

/// Receives the records of a file. Views are valid during the call.
class McapVisitor {
 public:
  McapVisitor() = default;
  McapVisitor(const McapVisitor&) = delete;
  McapVisitor& operator=(const McapVisitor&) = delete;
  virtual ~McapVisitor() = default;

  virtual void on_header(const McapHeader&) {}
  /// New ones only: not the repetitions in later chunks and in the summary.
  virtual void on_schema(const McapSchema&) {}
  virtual void on_channel(const McapChannel&) {}
  /// The channel has been handed over before.
  virtual void on_message(const McapMessage&, const McapSpot&) {}
  /// Before its messages, whether they can be read or not.
  virtual void on_chunk(const McapChunk&, const McapSpot&) {}
  virtual void on_message_index(const McapMessageIndex&, const McapSpot&) {}
  virtual void on_attachment(const McapAttachment&, const McapSpot&) {}
  virtual void on_metadata(const McapMetadata&, const McapSpot&) {}
  virtual void on_chunk_index(const McapChunkIndex&) {}
  virtual void on_attachment_index(const McapAttachmentIndex&) {}
  virtual void on_metadata_index(const McapMetadataIndex&) {}
  virtual void on_statistics(const McapStatistics&) {}
  virtual void on_summary_offset(const McapSummaryOffset&) {}
  virtual void on_data_end(const McapDataEnd&, const McapSpot&) {}
  virtual void on_footer(const McapFooter&, const McapSpot&) {}
  /// Something is wrong; the walk goes on behind it where it can.
  virtual void on_problem(const McapProblem&) = 0;
};

/// What the largest record, and the largest chunk uncompressed, may have: 1 GiB, which any message fits into.
inline constexpr std::uint64_t kMostMcapRecordBytes = std::uint64_t{1} << 30U;

/// Hands over a recording piece by piece, so that several can be read side by side.
///
/// Threads: one.
class RecordingReader {
 public:
  RecordingReader() = default;
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;
  virtual ~RecordingReader() = default;
  /// Hands over the next record; a chunk with all that it has. Returns false if the recording has ended, or a problem ended the walk.
  [[nodiscard]] virtual bool next() = 0;
  /// The end was reached.
  [[nodiscard]] virtual bool is_complete() const = 0;
};

/// Returns a reader that hands over what walk_mcap() does. `source` and `visitor` outlive it.
[[nodiscard]] std::unique_ptr<RecordingReader> read_mcap(ByteSource& source, McapVisitor& visitor);

/// Hands over all records of a file from its start to its end: those of chunks too, uncompressed, with their CRC checked.
///
/// The bytes are hostile: no content makes it read beyond a record, loop, or hold more memory than the file has (a compressed chunk: than it
/// states, up to kMostMcapRecordBytes). Returns false if a problem ended the walk early: the rest of the file was not read.
bool walk_mcap(ByteSource& source, McapVisitor& visitor);

/// Hands over parts of a file, in any order, as walk_mcap() does. It keeps the schemas and channels that it has met. Source and visitor outlive
/// it.
class McapParts {
 public:
  McapParts(ByteSource& source, McapVisitor& visitor);
  ~McapParts();
  McapParts(const McapParts&) = delete;
  McapParts& operator=(const McapParts&) = delete;

  /// Hands over the footer, and the summary if there is one. Returns false if the file has no footer, or they cannot be read; the visitor was
  /// told of the problem.
  [[nodiscard]] bool read_summary();
  /// Hands over the records from `offset` on, which must have this length together.
  [[nodiscard]] bool read(std::uint64_t offset, std::uint64_t length);

 private:
  class Walk;
  friend bool walk_mcap(ByteSource& source, McapVisitor& visitor);
  friend std::unique_ptr<RecordingReader> read_mcap(ByteSource& source, McapVisitor& visitor);
  const std::unique_ptr<Walk> walk_;
};

}  // namespace nacelle::record
