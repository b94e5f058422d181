// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "record/protocol/mcap_walk.hpp"

namespace nacelle::record {

/// A topic of a recording. Times are log times, in nanoseconds since the Unix epoch.
struct RecordedTopic {
  std::string name, type, encoding;
  bool has_definition = true;
  std::map<std::string, std::string> metadata;  ///< Of the channel: offered_qos_profiles, topic_type_hash.
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;  ///< Of the messages.
  std::uint64_t first = 0, last = 0;
  std::uint64_t longest_gap = 0, gap_at = 0;  ///< In ns, and the time of the message before it.

  /// Messages per second between the first and the last one; 0 for fewer than two.
  [[nodiscard]] double rate_hz() const;
};

/// What a recording has. Fill it by walk_mcap().
class RecordingSummary final : public McapVisitor {
 public:
  struct Attachment {
    std::string name, media_type;
    std::uint64_t bytes = 0;
  };

  [[nodiscard]] const std::string& profile() const { return profile_; }
  [[nodiscard]] const std::string& library() const { return library_; }
  /// In the order of their channels.
  [[nodiscard]] const std::map<std::uint16_t, RecordedTopic>& topics() const { return topics_; }
  [[nodiscard]] const std::vector<Attachment>& attachments() const { return attachments_; }
  [[nodiscard]] const std::map<std::string, std::map<std::string, std::string>>& metadata() const { return metadata_; }
  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  /// Of the first and the last message; 0 if there is none.
  [[nodiscard]] std::uint64_t first() const { return first_; }
  [[nodiscard]] std::uint64_t last() const { return last_; }
  /// By how many ns a message can be earlier than one that an earlier chunk has; 0 if the chunks follow each other in time.
  [[nodiscard]] std::uint64_t disorder() const { return disorder_; }
  [[nodiscard]] std::uint64_t chunks() const { return chunks_; }
  /// "none", "lz4", "zstd", or several: "lz4 and zstd".
  [[nodiscard]] std::string compression() const;
  /// The first ones, at most kMostProblems.
  [[nodiscard]] const std::vector<McapProblem>& problems() const { return problems_; }

  void on_header(const McapHeader& header) override;
  void on_schema(const McapSchema& schema) override;
  void on_channel(const McapChannel& channel) override;
  void on_message(const McapMessage& message, const McapSpot& spot) override;
  void on_chunk(const McapChunk& chunk, const McapSpot& spot) override;
  void on_attachment(const McapAttachment& attachment, const McapSpot& spot) override;
  void on_metadata(const McapMetadata& metadata, const McapSpot& spot) override;
  void on_problem(const McapProblem& problem) override {
    if (problems_.size() < kMostProblems) problems_.push_back(problem);
  }

  static constexpr std::size_t kMostProblems = 100;

 private:
  std::string profile_, library_;
  std::map<std::uint16_t, std::string> types_;  // of schemas
  std::set<std::uint16_t> undefined_;           // schemas without a text
  std::map<std::uint16_t, RecordedTopic> topics_;
  std::vector<Attachment> attachments_;
  std::map<std::string, std::map<std::string, std::string>> metadata_;
  std::map<std::string, std::uint64_t> compressions_;
  std::uint64_t messages_ = 0, first_ = 0, last_ = 0, chunks_ = 0;
  std::uint64_t disorder_ = 0, piece_ = 0, last_before_piece_ = 0;  // a piece: a chunk, or a message outside of one
  std::vector<McapProblem> problems_;
};

}  // namespace nacelle::record
