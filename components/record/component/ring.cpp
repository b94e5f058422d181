// SPDX-License-Identifier: Apache-2.0
#include "record/component/ring.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "nacelle/base/file_fault.hpp"
#include "record/component/kept_messages.hpp"

namespace nacelle::record {
namespace {

constexpr std::uint64_t kLeastBytes = 4 * kMegabyte;
constexpr std::size_t kDigits = 12;

bool is_number(std::string_view text) {
  return text.size() == kDigits && text.find_first_not_of("0123456789") == std::string_view::npos;
}

}  // namespace

std::string chunk_name(std::uint64_t chunk) { return fmt::format("{:0{}}.mcap", chunk, kDigits); }
std::string kept_name(std::uint64_t kept, std::uint64_t chunk) {
  return fmt::format("kept_{:0{}}_{:0{}}.mcap", kept, kDigits, chunk, kDigits);
}

std::string attached_name(std::uint64_t attached) { return fmt::format("run_{:0{}}.mcap", attached, kDigits); }

std::vector<std::string> in_ring_order(std::vector<std::string> paths) {
  constexpr std::string_view kRun = "run_", kKept = "kept_", kEnd = ".mcap";
  std::set<std::string, std::less<>> chunks;
  std::map<std::string, std::string> ordered;  // by a key: attachments, kept messages, chunks
  for (int round = 0; round < 2; ++round) {
    for (std::string& path : paths) {
      const std::string name = std::filesystem::path{path}.filename().string();
      if (!name.ends_with(kEnd)) continue;
      const std::string_view stem = std::string_view{name}.substr(0, name.size() - kEnd.size());
      if (round == 0 && is_number(stem)) {
        chunks.emplace(stem);
        ordered.emplace("2" + name, path);
      }
      if (round == 0 && stem.starts_with(kRun) && is_number(stem.substr(kRun.size())))
        ordered.emplace("0" + name, path);
      if (round == 0 || !stem.starts_with(kKept) || stem.size() != kKept.size() + 2 * kDigits + 1) continue;
      const std::string_view chunk = stem.substr(stem.size() - kDigits);
      if (is_number(stem.substr(kKept.size(), kDigits)) && is_number(chunk) && chunks.count(chunk) == 0)
        ordered.emplace("1" + name, path);
    }
  }
  std::vector<std::string> all;
  for (auto& [key, path] : ordered) all.push_back(std::move(path));
  return all;
}

Ring::Ring(RingOptions options, std::shared_ptr<RingFolder> folder)
    : options_(std::move(options)),
      folder_(std::move(folder)),
      writer_(memory_, {.compression = options_.compression}),
      // Each message is a chunk.
      kept_writer_(kept_memory_, {.compression = options_.compression, .chunk_bytes = 1}) {}

Result<std::unique_ptr<Ring>, Problem> Ring::begin(RingOptions options) {
  auto folder = RingFolder::make(options.base, options.name);
  if (!folder) return err(folder.error());
  const std::uint64_t free = (*folder)->free_bytes() + options.soon_free;
  if (free / 2 < kLeastBytes)
    return err(Problem{Place{options.base, 0},
                       fmt::format("is full: {} MB are free, a ring takes at most half of them and needs {} MB",
                                   free / kMegabyte, kLeastBytes / kMegabyte),
                       "make room in it; docker run --shm-size=1g makes a larger one", FileFault::NoRoom});
  options.most_bytes = std::min(options.most_bytes, free / 2);
  return std::unique_ptr<Ring>{new Ring{std::move(options), std::move(*folder)}};
}

std::optional<Duration> Ring::reach() const {
  return now_ - (chunks_.empty() ? writer_.pending() > 0 ? chunk_begun_ : now_ : chunks_.front().begun);
}

void Ring::drop_oldest() {
  bytes_ -= chunks_.front().file->bytes();
  chunks_.pop_front();
}

/// Nothing: not even an empty ring has room for it.
std::shared_ptr<const RingFile> Ring::add(const std::string& name, ByteView bytes) {
  while (!chunks_.empty() && stored() + bytes.size() > options_.most_bytes) drop_oldest();
  for (;;) {
    auto file = folder_->add(name, bytes);
    if (file) return std::move(*file);
    if (chunks_.empty()) {  // other programs have filled the memory
      problem_ = file.error();
      return nullptr;
    }
    drop_oldest();
  }
}

void Ring::store() {
  const std::uint64_t size = memory_.bytes.size();
  if (auto file = add(chunk_name(next_++), memory_.bytes)) {
    bytes_ += size;
    chunks_.push_back({std::move(file), chunk_begun_, now_});
    // One message may be larger than the ring.
    while (!chunks_.empty() && stored() > options_.most_bytes) drop_oldest();
  }
  memory_.bytes.clear();
}

void Ring::forget_kept(const std::deque<Kept>::iterator& which) {
  kept_bytes_ -= which->file->bytes();
  kept_.erase(which);
}

void Ring::keep(std::size_t index, const void* message, const MessageStamps& stamps, std::uint64_t chunk) {
  const Topic& topic = topics_[index];
  const std::size_t size = topic.type->encoded_size(message), most = options_.most_bytes / 2;
  if (size > most) return;
  kept_memory_.bytes.clear();
  const bool is_encoded =
      kept_writer_.start_another() &&
      kept_writer_.write({channel_of(topic, kept_writer_).value_or(0), 0, stamps.log_time, stamps.publish_time, {}},
                         size, [&](ByteSpan out) { topic.type->encode(message, out.data()); });
  if (!is_encoded) return;
  auto file = add(kept_name(next_kept_++, chunk), kept_memory_.bytes);
  if (!file) return;
  const auto is_of_same = [&](const Kept& other) { return other.topic == index && other.writer == stamps.writer; };
  const auto others = static_cast<std::size_t>(std::count_if(kept_.begin(), kept_.end(), is_of_same));
  if (others >= kept_depth(topic.known.offered)) forget_kept(std::find_if(kept_.begin(), kept_.end(), is_of_same));
  kept_bytes_ += file->bytes();
  kept_.push_back({std::move(file), index, stamps.writer});
  while (kept_bytes_ > most && kept_.size() > 1) forget_kept(kept_.begin());
}

void Ring::attach(const RunText& text, std::uint64_t time) {
  if (attached_bytes_ + text.text.size() > options_.most_bytes / 4) return;
  kept_memory_.bytes.clear();
  if (problem_ || !kept_writer_.start_another() || !write_attachment(text, time, kept_writer_)) return;
  auto file = add(attached_name(attached_.size()), kept_memory_.bytes);
  if (!file) return;
  attached_bytes_ += file->bytes();
  attached_.push_back(std::move(file));
}

void Ring::write(std::size_t index, const void* message, const MessageStamps& stamps) {
  if (problem_) return;
  Topic& topic = topics_[index];
  const std::size_t size = topic.type->encoded_size(message);
  if (size >= options_.most_bytes) {
    ++topic.lost;
    return;
  }
  if (writer_.pending() == 0) {
    if (!writer_.start_another()) return;
    chunk_begun_ = now_;
  }
  const std::uint64_t chunk = next_;
  const McapMessage record{channel_of(topic, writer_).value_or(0), 0, stamps.log_time, stamps.publish_time, {}};
  if (!writer_.write(record, size, [&](ByteSpan out) { topic.type->encode(message, out.data()); })) {
    problem_ = Problem{Place{folder(), 0}, "a ring holds at most 65,535 topics", "record fewer"};
    return;
  }
  count(topic, size);
  if (writer_.pending() == 0) store();
  if (is_latched(topic.known.offered) && !problem_) keep(index, message, stamps, chunk);
}

void Ring::look_at_time(MonotonicTime now) {
  now_ = now;
  if (writer_.pending() > 0 && now - chunk_begun_ >= kChunkTime && writer_.close_chunk()) store();
  while (!chunks_.empty() && now - chunks_.front().closed > options_.longest) drop_oldest();
}

Ring::Files Ring::content() {
  if (writer_.pending() > 0 && writer_.close_chunk()) store();
  Files all = attached_;
  for (const Kept& one : kept_) all.push_back(one.file);
  for (const Chunk& one : chunks_) all.push_back(one.file);
  return all;
}

}  // namespace nacelle::record
