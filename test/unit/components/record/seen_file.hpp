// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "record/protocol/mcap_walk.hpp"

namespace nacelle::record {

/// A file in memory: what is written can be read. After `room` bytes it is full.
class MemoryFile final : public ByteSink, public ByteSource {
 public:
  MemoryFile() = default;
  explicit MemoryFile(Bytes content) : bytes(std::move(content)) {}
  bool write(ByteView more) override {
    ++writes;
    if (bytes.size() + more.size() > room) return false;
    bytes.insert(bytes.end(), more.begin(), more.end());
    return true;
  }
  std::uint64_t size() const override { return bytes.size(); }
  bool read_at(std::uint64_t offset, ByteSpan out) override {
    if (offset > bytes.size() || out.size() > bytes.size() - offset) return false;
    if (!out.empty()) std::memcpy(out.data(), bytes.data() + offset, out.size());
    return true;
  }

  Bytes bytes;
  std::size_t room = SIZE_MAX;
  int writes = 0;
};

/// What a walk hands over, in its order, as text.
class SeenFile final : public McapVisitor {
 public:
  explicit SeenFile(ByteSource& source) : complete(walk_mcap(source, *this)) {}

  void on_header(const McapHeader& header) override { note("header " + header.profile + " " + header.library); }
  void on_schema(const McapSchema& schema) override {
    note("schema " + std::to_string(schema.id) + " " + schema.name + " " + schema.encoding + " " +
         std::string{as_text(schema.data.bytes)});
  }
  void on_channel(const McapChannel& channel) override {
    std::string text = "channel " + std::to_string(channel.id) + " of " + std::to_string(channel.schema_id) + " " +
                       channel.topic + " " + channel.message_encoding;
    for (const auto& [key, value] : channel.metadata) text.append(" ").append(key).append("=").append(value);
    note(text);
  }
  void on_message(const McapMessage& message, const McapSpot& spot) override {
    note("message " + std::to_string(message.channel_id) + " #" + std::to_string(message.sequence) + " at " +
         std::to_string(message.log_time) + " of " + std::to_string(message.publish_time) + ": " +
         std::string{as_text(message.data.bytes)});
    spots.emplace_back(message.log_time, spot.in_chunk);
  }
  void on_chunk(const McapChunk& chunk, const McapSpot& spot) override {
    chunk_spots.push_back(spot);
    note("chunk " + std::to_string(chunk.message_start_time) + ".." + std::to_string(chunk.message_end_time) + " '" +
         chunk.compression + "'");
  }
  void on_message_index(const McapMessageIndex& index, const McapSpot&) override {
    indexes.insert(indexes.end(), index.entries.begin(), index.entries.end());
  }
  void on_attachment(const McapAttachment& attachment, const McapSpot&) override {
    note("attachment " + attachment.name + " " + attachment.media_type + ": " +
         std::string{as_text(attachment.data.bytes)});
  }
  void on_metadata(const McapMetadata& metadata, const McapSpot&) override {
    std::string text = "metadata " + metadata.name;
    for (const auto& [key, value] : metadata.metadata) text.append(" ").append(key).append("=").append(value);
    note(text);
  }
  void on_chunk_index(const McapChunkIndex& index) override { chunk_indexes.push_back(index); }
  void on_statistics(const McapStatistics& found) override { statistics = found; }
  void on_summary_offset(const McapSummaryOffset& offset) override { groups.push_back(offset); }
  void on_footer(const McapFooter& found, const McapSpot&) override { footer = found; }
  void on_problem(const McapProblem& problem) override {
    problems.push_back(problem.fault);
    note("problem at " + std::to_string(problem.offset) + ": " + problem.what);
  }

  std::vector<std::string> lines;
  std::vector<McapFault> problems;
  std::vector<McapSpot> chunk_spots;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> spots, indexes;
  std::vector<McapChunkIndex> chunk_indexes;
  std::vector<McapSummaryOffset> groups;
  McapStatistics statistics;
  McapFooter footer;
  bool complete;  // last: the walk fills the others

 private:
  void note(std::string line) { lines.push_back(std::move(line)); }
};

}  // namespace nacelle::record
