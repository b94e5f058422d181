// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "record/protocol/mcap_walk.hpp"
#include "record/protocol/mcap_writer.hpp"

namespace nacelle::record {

/// Copies what a walk hands over into a new file: messages in their chunks, attachments, metadata; indexes and the summary are made
/// anew. What cannot be read is left out.
class RecordingCopy final : public McapVisitor {
 public:
  explicit RecordingCopy(McapWriter& writer) : writer_(writer) {}

  /// Nothing more can be written: the sink failed.
  [[nodiscard]] bool has_failed() const { return failed_; }
  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  [[nodiscard]] std::uint64_t problems() const { return problems_; }

  void on_schema(const McapSchema& schema) override;
  void on_channel(const McapChannel& channel) override;
  void on_message(const McapMessage& message, const McapSpot& spot) override;
  void on_chunk(const McapChunk& chunk, const McapSpot& spot) override;
  void on_attachment(const McapAttachment& attachment, const McapSpot& spot) override;
  void on_metadata(const McapMetadata& metadata, const McapSpot& spot) override;
  void on_problem(const McapProblem&) override { ++problems_; }

 private:
  void expect(bool done) { failed_ = failed_ || !done; }

  McapWriter& writer_;
  bool failed_ = false;
  std::uint64_t messages_ = 0, problems_ = 0;
  std::map<std::uint16_t, std::uint16_t> schemas_, channels_;  // ids there and here
};

}  // namespace nacelle::record
