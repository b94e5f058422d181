// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_check.hpp"

#include <algorithm>

#include "record/protocol/compression.hpp"

namespace nacelle::record {

RecordingCheck::Report RecordingCheck::run() {
  report_ = {};
  report_.complete = walk_mcap(source_, *this);
  end_chunk();
  return std::move(report_);
}

void RecordingCheck::on_problem(const McapProblem& problem) {
  ++report_.problem_count;
  if (report_.problems.size() < kMostProblems) report_.problems.push_back(problem);
}

void RecordingCheck::check_crc(std::uint32_t stated, std::uint64_t begin, std::uint64_t end, const char* what) {
  if (stated == 0 || end < begin || end > source_.size()) return;
  ++report_.checksums;
  Bytes part(std::size_t{1} << 16U);
  std::uint32_t crc = 0;
  for (std::uint64_t at = begin; at < end;) {
    const ByteSpan some{part.data(), static_cast<std::size_t>(std::min<std::uint64_t>(part.size(), end - at))};
    if (!source_.read_at(at, some)) return tell(McapFault::Unreadable, at, "reading failed");
    crc = crc32_of(some, crc);
    at += some.size();
  }
  if (crc != stated) tell(McapFault::BadCrc, begin, what);
}

void RecordingCheck::on_schema(const McapSchema& schema) {
  types_[schema.id] = schema.name;
  ++schemas_;
}

void RecordingCheck::on_channel(const McapChannel& channel) {
  channels_[channel.id] = {channel.schema_id == 0 ? "" : types_[channel.schema_id], channel.message_encoding, 0};
}

void RecordingCheck::on_chunk(const McapChunk& chunk, const McapSpot& spot) {
  end_chunk();
  chunk_is_open_ = true;
  chunk_at_ = spot.offset;
  SeenChunk& seen = chunks_[spot.offset];
  seen.chunk = chunk;
  seen.chunk.records.bytes = {};
  seen.length = spot.length;
  ++report_.chunks;
  if (chunk.uncompressed_crc != 0) ++report_.checksums;
}

void RecordingCheck::on_message(const McapMessage& message, const McapSpot& spot) {
  const std::uint64_t at = message.log_time;
  first_ = report_.messages == 0 ? at : std::min(first_, at);
  last_ = report_.messages == 0 ? at : std::max(last_, at);
  ++report_.messages;
  Channel& channel = channels_[message.channel_id];
  ++channel.messages;
  if (chunk_is_open_ && spot.offset == chunk_at_) {
    in_chunk_[message.channel_id].emplace_back(at, spot.in_chunk);
    const McapChunk& chunk = chunks_[chunk_at_].chunk;
    if (at < chunk.message_start_time || at > chunk.message_end_time)
      tell(McapFault::BadIndex, spot.offset, "a message has a time outside of its chunk's");
  }
  switch (payload_ ? payload_(channel.type, channel.encoding, message.data.bytes) : PayloadVerdict::UnknownType) {
    case PayloadVerdict::Good: break;
    case PayloadVerdict::Bad: tell(McapFault::BadPayload, spot.offset, "a message's bytes are none of its type"); break;
    case PayloadVerdict::UnknownType: ++report_.unread[channel.type]; break;
  }
}

void RecordingCheck::on_message_index(const McapMessageIndex& index, const McapSpot& spot) {
  if (!chunk_is_open_) return tell(McapFault::BadIndex, spot.offset, "a message index follows no chunk");
  has_index_ = true;
  of_index_[index.channel_id] = index.entries;
  SeenChunk& chunk = chunks_[chunk_at_];
  chunk.message_index_offsets[index.channel_id] = spot.offset;
  chunk.message_index_length += spot.length;
}

void RecordingCheck::end_chunk() {
  if (chunk_is_open_ && has_index_) {
    for (auto* entries : {&in_chunk_, &of_index_}) {
      for (auto& [channel, times] : *entries) std::sort(times.begin(), times.end());
    }
    std::erase_if(of_index_, [](const auto& entry) { return entry.second.empty(); });
    if (in_chunk_ != of_index_) {
      tell(McapFault::BadIndex, chunk_at_, "a chunk's message indexes do not lead to its messages");
    } else {
      for (const auto& [channel, times] : of_index_) report_.indexed += times.size();
    }
  }
  in_chunk_.clear();
  of_index_.clear();
  has_index_ = chunk_is_open_ = false;
}

void RecordingCheck::on_attachment(const McapAttachment& attachment, const McapSpot& spot) {
  end_chunk();
  ++report_.attachments;
  if (attachment.crc != 0) ++report_.checksums;
  attachments_[spot.offset] = {spot.length, attachment.name};
}

void RecordingCheck::on_metadata(const McapMetadata& metadata, const McapSpot& spot) {
  end_chunk();
  metadata_[spot.offset] = {spot.length, metadata.name};
}

void RecordingCheck::on_chunk_index(const McapChunkIndex& index) {
  const auto found = chunks_.find(index.chunk_start_offset);
  if (found == chunks_.end())
    return tell(McapFault::BadIndex, index.chunk_start_offset, "a chunk index leads to no chunk");
  const SeenChunk& seen = found->second;
  indexed_chunks_.insert(found->first);
  if (index.chunk_length != seen.length || index.uncompressed_size != seen.chunk.uncompressed_size ||
      index.compression != seen.chunk.compression || index.message_start_time != seen.chunk.message_start_time ||
      index.message_end_time != seen.chunk.message_end_time)
    tell(McapFault::BadIndex, found->first, "a chunk is not as its index says");
  if (index.message_index_offsets != seen.message_index_offsets ||
      index.message_index_length != seen.message_index_length)
    tell(McapFault::BadIndex, found->first, "a chunk index does not lead to the chunk's message indexes");
}

void RecordingCheck::on_attachment_index(const McapAttachmentIndex& index) {
  const auto found = attachments_.find(index.offset);
  if (found == attachments_.end() || found->second != std::pair{index.length, index.name})
    tell(McapFault::BadIndex, index.offset, "an attachment index leads to no attachment of that name");
}

void RecordingCheck::on_metadata_index(const McapMetadataIndex& index) {
  const auto found = metadata_.find(index.offset);
  if (found == metadata_.end() || found->second != std::pair{index.length, index.name})
    tell(McapFault::BadIndex, index.offset, "a metadata index leads to no metadata of that name");
}

void RecordingCheck::on_statistics(const McapStatistics& s) {
  std::map<std::uint16_t, std::uint64_t> counts;
  for (const auto& [id, channel] : channels_) {
    if (channel.messages > 0) counts[id] = channel.messages;
  }
  auto stated = s.channel_message_counts;
  std::erase_if(stated, [](const auto& entry) { return entry.second == 0; });
  if (s.message_count != report_.messages || s.chunk_count != report_.chunks ||
      s.attachment_count != report_.attachments || s.metadata_count != metadata_.size() || stated != counts)
    tell(McapFault::BadIndex, 0, "the statistics count something else than the file has");
  if (report_.messages > 0 && (s.message_start_time != first_ || s.message_end_time != last_))
    tell(McapFault::BadIndex, 0, "the statistics have other times than the messages");
}

void RecordingCheck::on_summary_offset(const McapSummaryOffset& offset) { groups_.push_back(offset); }

void RecordingCheck::on_data_end(const McapDataEnd& end, const McapSpot& spot) {
  end_chunk();
  has_data_end_ = true;
  check_crc(end.data_section_crc, 0, spot.offset, "the CRC of the data section does not match");
}

void RecordingCheck::on_footer(const McapFooter& footer, const McapSpot& spot) {
  if (!has_header_) tell(McapFault::BadRecord, 0, "the file has no header");
  if (!has_data_end_) tell(McapFault::BadRecord, spot.offset, "no record says where the data end");
  if (!indexed_chunks_.empty() && indexed_chunks_.size() != chunks_.size())
    tell(McapFault::BadIndex, spot.offset, "some chunks have no index");
  if (footer.summary_start != 0)
    check_crc(footer.summary_crc, footer.summary_start, spot.offset + spot.length - 4,
              "the summary's CRC does not match");
  for (const McapSummaryOffset& group : groups_) {
    std::uint8_t opcode = 0;
    const bool inside = group.group_start >= footer.summary_start && group.group_start < spot.offset &&
                        group.group_length <= spot.offset - group.group_start;
    if (!inside || !source_.read_at(group.group_start, {&opcode, 1}) || opcode != group.group_opcode)
      tell(McapFault::BadIndex, group.group_start, "a summary offset leads to no record of its kind");
  }
}

}  // namespace nacelle::record
