// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>

#include "record/protocol/mcap_walk.hpp"
#include "record/protocol/mcap_writer.hpp"

namespace nacelle::record {

/// What of a recording is wanted.
struct RecordingSelection {
  std::function<bool(const std::string& topic)> wants_topic;  ///< Empty: all.
  /// Log times in nanoseconds since the Unix epoch, both ends included.
  std::uint64_t from = 0, to = std::numeric_limits<std::uint64_t>::max();
};

/// Copies what a walk hands over into a new file: messages in their chunks, attachments, metadata; indexes and the summary are made
/// anew. What cannot be read is left out. Several recordings can be copied into one file, by a copy each.
class RecordingCopy final : public McapVisitor {
 public:
  explicit RecordingCopy(McapWriter& writer, RecordingSelection selection = {})
      : writer_(writer), selection_(std::move(selection)) {}

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

  struct Schema {
    std::string name, encoding, text;
  };

  McapWriter& writer_;
  const RecordingSelection selection_;
  bool failed_ = false;
  std::uint64_t messages_ = 0, problems_ = 0;
  std::map<std::uint16_t, Schema> schemas_;          // by their ids there
  std::map<std::uint16_t, std::uint16_t> channels_;  // ids there and here, of wanted ones
};

}  // namespace nacelle::record
