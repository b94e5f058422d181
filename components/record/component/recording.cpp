// SPDX-License-Identifier: Apache-2.0
#include "record/component/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "record/port/recording_folder.hpp"

namespace nacelle::record {
namespace {

constexpr std::size_t kMostLatchedBytes = 16 * kMegabyte;

}  // namespace

Recording::Recording(RecordingOptions options)
    : options_(std::move(options)), disk_(options_.most_waiting), latched_(kMostLatchedBytes) {}

Result<std::unique_ptr<Recording>, Problem> Recording::begin(RecordingOptions options) {
  if (auto problem = make_recording_folder(options.folder)) return err(std::move(*problem));
  std::unique_ptr<Recording> made{new Recording{std::move(options)}};
  if (auto problem = made->open_file()) return err(std::move(*problem));
  return made;
}

std::optional<Problem> Recording::open_file() {
  const std::string name =
      fmt::format("{}_{}.mcap", std::filesystem::path{options_.folder}.filename().string(), metadata_.files.size());
  path_ = (std::filesystem::path{options_.folder} / name).string();
  auto file = FileSink::create(path_);
  if (!file) return file.error();
  sink_ = std::make_unique<QueuedFile>(disk_, std::shared_ptr<FileSink>{std::move(*file)});
  writer_ = std::make_unique<McapWriter>(*sink_, McapWriterOptions{.compression = options_.compression});
  metadata_.files.push_back({name});
  repeated_bytes_ = 0;
  channels_.clear();
  if (!writer_->start()) return disk_.problem();
  return std::nullopt;
}

void Recording::close_file() {
  if (!writer_) return;
  BagMetadata known = metadata_;
  for (const Topic& topic : topics_) known.topics.push_back(topic.known);
  const bool has_words = is_finished_ && !words_.empty();
  const bool is_complete =
      writer_->close_chunk() && (!has_words || writer_->write_metadata({kRecorderRecord, words_})) &&
      writer_->write_metadata({"rosbag2", {{"serialized_metadata", metadata_yaml(known)}}}) && writer_->finish();
  if (!is_complete && !problem_) problem_ = disk_.problem();
  earlier_bytes_ += writer_->written();
  writer_.reset();
  sink_.reset();
}

void Recording::end(Problem problem) {
  problem_ = std::move(problem);
  close_file();
}

void Recording::split() {
  if (!writer_) return;
  close_file();
  if (problem_) return;
  if (auto problem = open_file()) return end(std::move(*problem));
  repeat_latched();
}

void Recording::repeat_latched() {
  for (const auto& kept : latched_.all()) {
    const auto copy = [&](ByteSpan out) { std::copy(kept.bytes.begin(), kept.bytes.end(), out.begin()); };
    if (!store(kept.topic, kept.bytes.size(), last_time_, last_time_, copy)) return;
  }
  repeated_bytes_ = writer_->written() + writer_->pending();
}

std::uint64_t Recording::bytes() const {
  return earlier_bytes_ + (writer_ ? writer_->written() + writer_->pending() : 0);
}

// What the open chunk and the summary take must be left, or the file would not be complete.
bool Recording::has_space() {
  constexpr std::uint64_t kSummary = std::uint64_t{1} << 20U;
  return disk_.free_bytes() >= options_.keep_free + writer_->pending() + kSummary;
}

std::uint16_t Recording::channel(std::size_t index) {
  if (channels_.size() <= index) channels_.resize(index + 1);
  auto& known = channels_[index];
  if (!known) known = channel_of(topics_[index], *writer_);
  return known.value_or(0);
}

void Recording::write(std::size_t index, const void* message, const MessageStamps& stamps) {
  const std::uint64_t log_time = stamps.log_time;
  if (!writer_) return;
  Topic& topic = topics_[index];
  const std::size_t size = topic.type->encoded_size(message);
  if (disk_.room() < writer_->pending() + size) {
    ++topic.lost;
    return;
  }
  if (!has_space()) {
    return end({Place{options_.folder, 0},
                fmt::format("the disk is full: {} MB are free, and {} MB of them are left to others",
                            disk_.free_bytes() / kMegabyte, options_.keep_free / kMegabyte),
                "make room, or lower storage.keep_free"});
  }
  const bool is_kept = options_.repeats_latched && is_latched(topic.known.offered);
  const bool is_stored = store(index, size, log_time, stamps.publish_time, [&](ByteSpan out) {
    topic.type->encode(message, out.data());
    if (is_kept) latched_.keep(index, stamps.writer, out, kept_depth(topic.known.offered));
  });
  if (!is_stored) return;
  last_time_ = std::max(last_time_, log_time);
  const std::uint64_t bytes = writer_->written() + writer_->pending() - repeated_bytes_;
  if (options_.max_file_bytes != 0 && bytes >= options_.max_file_bytes) return split();
  const BagFile& file = metadata_.files.back();
  const auto longest = static_cast<std::uint64_t>(options_.max_file_duration.count());
  if (longest != 0 && file.last - file.first >= longest) split();
}

template <typename Fill>
bool Recording::store(std::size_t index, std::size_t size, std::uint64_t log_time, std::uint64_t publish_time,
                      Fill&& fill) {
  const bool begins_chunk = writer_->pending() == 0;
  const McapMessage record{channel(index), 0, log_time, publish_time, {}};
  if (record.channel_id == 0 || !writer_->write(record, size, std::forward<Fill>(fill))) {
    end(disk_.problem().value_or(Problem{Place{path_, 0}, "an MCAP file holds at most 65,535 topics",
                                         "record fewer: storage.max_bagfile_size splits files"}));
    return false;
  }
  if (begins_chunk) chunk_begun_ = now_;
  BagFile& file = metadata_.files.back();
  file.first = file.messages == 0 ? log_time : std::min(file.first, log_time);
  file.last = std::max(file.last, log_time);
  ++file.messages;
  count(topics_[index], size);
  return true;
}

void Recording::attach(const RunText& text, std::uint64_t time) {
  if (writer_ && has_space() && !write_attachment(text, time, *writer_) && disk_.problem()) end(*disk_.problem());
}

void Recording::look_at_time(MonotonicTime now) {
  now_ = now;
  if (!writer_) return;
  if (writer_->pending() > 0 && now - chunk_begun_ >= kChunkTime && !writer_->close_chunk() && disk_.problem())
    return end(*disk_.problem());
  if (auto problem = disk_.problem()) end(std::move(*problem));
}

std::optional<Problem> Recording::finish() {
  if (std::exchange(is_finished_, true)) return problem_;
  close_file();
  disk_.drain();
  if (!problem_) problem_ = disk_.problem();
  for (const Topic& topic : topics_) metadata_.topics.push_back(topic.known);
  auto file = FileSink::create((std::filesystem::path{options_.folder} / "metadata.yaml").string());
  if (!file) return problem_ ? problem_ : file.error();
  const bool is_written = (*file)->write(as_bytes(metadata_yaml(metadata_))) && (*file)->sync();
  if (!is_written && !problem_) problem_ = (*file)->problem();
  return problem_;
}

}  // namespace nacelle::record
