// SPDX-License-Identifier: Apache-2.0
#include "record/component/snapshot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "nacelle/base/file_fault.hpp"
#include "record/component/ring.hpp"
#include "record/model/bag_metadata.hpp"
#include "record/model/recording_copy.hpp"
#include "record/port/recording_file.hpp"
#include "record/port/recording_folder.hpp"

namespace nacelle::record {
namespace {

constexpr int kMostFolders = 10'000;

/// Copies one file of a ring, and counts for metadata.yaml.
class Part final : public McapVisitor {
 public:
  Part(McapWriter& writer, BagMetadata& whole) : copy_(writer), whole_(whole) {}

  [[nodiscard]] bool has_failed() const { return copy_.has_failed(); }
  [[nodiscard]] std::uint64_t problems() const { return problems_; }

  void on_schema(const McapSchema& schema) override {
    types_[schema.id] = schema.name;
    copy_.on_schema(schema);
  }
  void on_channel(const McapChannel& channel) override {
    const std::string& type = types_[channel.schema_id];
    auto& topics = whole_.topics;
    auto topic = std::find_if(topics.begin(), topics.end(),
                              [&](const BagTopic& one) { return one.name == channel.topic && one.type == type; });
    if (topic == topics.end()) {
      const auto text = [&](const char* key) {
        const auto found = channel.metadata.find(key);
        return found == channel.metadata.end() ? std::string{} : found->second;
      };
      topics.push_back({channel.topic, type, text("topic_type_hash"), read_qos_profiles(text("offered_qos_profiles"))});
      topic = std::prev(topics.end());
    }
    topics_[channel.id] = static_cast<std::size_t>(topic - topics.begin());
    copy_.on_channel(channel);
  }
  void on_message(const McapMessage& message, const McapSpot& spot) override {
    BagFile& file = whole_.files.back();
    file.first = file.messages == 0 ? message.log_time : std::min(file.first, message.log_time);
    file.last = std::max(file.last, message.log_time);
    ++file.messages;
    ++whole_.topics[topics_[message.channel_id]].messages;
    copy_.on_message(message, spot);
  }
  void on_chunk(const McapChunk& chunk, const McapSpot& spot) override { copy_.on_chunk(chunk, spot); }
  void on_attachment(const McapAttachment& attachment, const McapSpot& spot) override {
    copy_.on_attachment(attachment, spot);
  }
  void on_problem(const McapProblem& problem) override {
    // No file of a ring has an end; of the one that was being written at a kill the chunk is cut.
    if (problem.fault != McapFault::Truncated) ++problems_;
  }

 private:
  RecordingCopy copy_;
  BagMetadata& whole_;
  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, std::size_t> topics_;  // numbers, by channel
  std::uint64_t problems_ = 0;
};

/// The folder, or the first of its kind that is not there.
Result<std::string, Problem> make_folder(const std::string& wanted) {
  for (int number = 1;; ++number) {
    std::string path = number == 1 ? wanted : fmt::format("{}_{}", wanted, number);
    auto problem = make_recording_folder(path);
    if (!problem) return path;
    std::error_code unknown;
    const bool is_there = std::filesystem::exists(std::filesystem::symlink_status(path, unknown));
    if (!is_there || number == kMostFolders) return err(std::move(*problem));
  }
}

std::uint64_t size_of(const std::vector<std::string>& files) {
  std::uint64_t sum = 0;
  for (const std::string& file : files) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    if (!error) sum += size;
  }
  return sum;
}

std::optional<Problem> fill(const SnapshotWish& wish, Snapshot& made) {
  const std::filesystem::path folder{made.folder};
  BagMetadata whole;
  whole.files.push_back({folder.filename().string() + "_0.mcap"});
  auto sink = FileSink::create((folder / whole.files.back().name).string());
  if (!sink) return sink.error();
  const auto files = in_ring_order(wish.files);
  const std::uint64_t free = (*sink)->free_bytes(), needed = size_of(files);
  if (free < wish.keep_free + needed)
    return Problem{Place{made.folder, 0},
                   fmt::format("the disk is full: {} MB are free, the snapshot has {} MB, and {} MB are left to others",
                               free / kMegabyte, needed / kMegabyte, wish.keep_free / kMegabyte),
                   "make room, or lower storage.keep_free", FileFault::NoRoom};
  McapWriter writer{**sink, {.compression = wish.compression}};
  bool is_good = writer.start();
  for (const std::string& file : files) {
    auto source = FileSource::open(file);
    if (!source) {
      ++made.problems;
      continue;
    }
    Part part{writer, whole};
    walk_mcap(**source, part);
    made.problems += part.problems();
    is_good = is_good && !part.has_failed();
    if (!is_good) break;
  }
  made.messages = whole.files.back().messages;
  if (made.messages == 0 && made.problems > 0)
    return Problem{Place{std::filesystem::path{files.front()}.parent_path().string(), 0},
                   "has nothing that can be read", "it is no ring of a recorder, or damaged: remove it",
                   McapFault::BadRecord};
  const std::string yaml = metadata_yaml(whole);
  is_good = is_good && writer.close_chunk() && writer.write_metadata({"nacelle.snapshot", {{"reason", wish.reason}}}) &&
            writer.write_metadata({"rosbag2", {{"serialized_metadata", yaml}}}) && writer.finish() && (*sink)->sync();
  if (!is_good) {
    return (*sink)->has_failed()
               ? (*sink)->problem()
               : Problem{Place{made.folder, 0}, "a snapshot holds at most 65,535 topics", "record fewer"};
  }
  made.bytes = writer.written();
  auto text = FileSink::create((folder / "metadata.yaml").string());
  if (!text) return text.error();
  if (!(*text)->write(as_bytes(yaml)) || !(*text)->sync()) return (*text)->problem();
  return std::nullopt;
}

}  // namespace

Result<Snapshot, Problem> write_snapshot(const SnapshotWish& wish) {
  auto folder = make_folder(wish.folder);
  if (!folder) return err(folder.error());
  Snapshot made{.folder = std::move(*folder)};
  if (auto problem = fill(wish, made)) {
    std::error_code ignored;
    std::filesystem::remove_all(made.folder, ignored);
    return err(std::move(*problem));
  }
  return made;
}

}  // namespace nacelle::record
