// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "record/component/kept_messages.hpp"
#include "record/component/message_log.hpp"
#include "record/model/bag_metadata.hpp"
#include "record/port/disk_queue.hpp"
#include "record/protocol/mcap_writer.hpp"

namespace nacelle::record {

/// As storage.keep_free and storage.max_cache_size count.
inline constexpr std::uint64_t kMegabyte = 1'000'000;
/// A chunk closes when it is as old.
inline constexpr Duration kChunkTime = 1s;

struct RecordingOptions {
  std::string folder;  ///< Of the recording; it must not exist.
  Compression compression = Compression::None;
  std::uint64_t max_file_bytes = 0;           ///< A file that reaches it is followed by another one; 0: never.
  Duration max_file_duration{};               ///< The same; zero: never.
  std::size_t most_waiting = 32 * kMegabyte;  ///< Bytes that may wait for the disk.
  std::uint64_t keep_free = 64 * kMegabyte;   ///< Bytes of the file system that the recording leaves.
  bool repeats_latched = true;  ///< Each file after a split begins with what transient_local publishers keep.
};

/// A recording that grows: a folder with its MCAP files and metadata.yaml, as `ros2 bag record` makes it.
///
/// Chunks close after 1 s or 1 MiB, and the disk has them a second later at the latest. Where the disk is too slow, messages are lost and
/// counted; where it is full, or does not take the bytes, the recording ends, and its file is complete.
///
/// Each file stands alone: after a split the next one repeats the last messages of latched topics, up to 16 MB, with the time of the last message before
/// it, as rosbag2 does with --repeat-all-transient-local.
/// Threads: one. Errors: of begin(), the folder or the first file cannot be made; later ones are in problem().
class Recording final : public MessageLog {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Recording>, Problem> begin(RecordingOptions options);
  ~Recording() override { static_cast<void>(finish()); }

  void write(std::size_t index, const void* message, const MessageStamps& stamps) override;
  /// Of several files, the open one has it.
  void attach(const RunText& text, std::uint64_t time) override;
  void look_at_time(MonotonicTime now) override;
  /// Waits until so many bytes more can wait for the disk.
  void await_room(std::size_t bytes) const { disk_.await_room(bytes + writer_room()); }
  /// Waits until the disk has the chunks that are closed.
  void flush() { disk_.drain(); }
  /// Errors: problem() says which.
  void split() override;
  void say_at_end(const std::map<std::string, std::string>& words) override { words_ = words; }
  /// Completes the last file, waits until the disk has it, and writes metadata.yaml.
  std::optional<Problem> finish() final;

  [[nodiscard]] const std::string& folder() const override { return options_.folder; }
  [[nodiscard]] const std::string& file() const override { return path_; }
  [[nodiscard]] std::size_t files() const override { return metadata_.files.size(); }
  [[nodiscard]] std::uint64_t bytes() const override;

 private:
  explicit Recording(RecordingOptions options);
  [[nodiscard]] std::optional<Problem> open_file();
  void close_file();
  void end(Problem problem);
  /// Writes a message of that size, whose bytes `fill` makes. Returns false if the recording has ended.
  template <typename Fill>
  bool store(std::size_t index, std::size_t size, std::uint64_t log_time, std::uint64_t publish_time, Fill&& fill);
  void repeat_latched();
  [[nodiscard]] bool has_space();
  [[nodiscard]] std::size_t writer_room() const { return writer_ ? writer_->pending() : 0; }
  [[nodiscard]] std::uint16_t channel(std::size_t index);

  const RecordingOptions options_;
  DiskQueue disk_;
  std::vector<std::optional<std::uint16_t>> channels_;  // of the open file, by topic
  BagMetadata metadata_;
  std::string path_;
  std::unique_ptr<QueuedFile> sink_;
  std::unique_ptr<McapWriter> writer_;  // of the open file; null: the recording has ended
  std::uint64_t earlier_bytes_ = 0;
  KeptMessages latched_;
  std::uint64_t last_time_ = 0, repeated_bytes_ = 0;  // of the open file
  std::map<std::string, std::string> words_;
  MonotonicTime now_{}, chunk_begun_{};
  bool is_finished_ = false;
};

}  // namespace nacelle::record
