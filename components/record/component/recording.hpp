// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "record/model/bag_metadata.hpp"
#include "record/port/disk_queue.hpp"
#include "record/protocol/mcap_writer.hpp"

namespace nacelle::record {

/// As storage.keep_free and storage.max_cache_size count.
inline constexpr std::uint64_t kMegabyte = 1'000'000;

struct RecordingOptions {
  std::string folder;  ///< Of the recording; it must not exist.
  Compression compression = Compression::None;
  std::uint64_t max_file_bytes = 0;           ///< A file that reaches it is followed by another one; 0: never.
  Duration max_file_duration{};               ///< The same; zero: never.
  std::size_t most_waiting = 32 * kMegabyte;  ///< Bytes that may wait for the disk.
  std::uint64_t keep_free = 64 * kMegabyte;   ///< Bytes of the file system that the recording leaves.
};

/// A recording that grows: a folder with its MCAP files and metadata.yaml, as `ros2 bag record` makes it.
///
/// Chunks close after 1 s or 1 MiB, and the disk has them a second later at the latest. Where the disk is too slow, messages are lost and
/// counted; where it is full, the recording ends, and its file is complete.
/// Threads: one. Errors: of begin(), the folder or the first file cannot be made; later ones are in problem().
class Recording {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Recording>, Problem> begin(RecordingOptions options);
  ~Recording() { static_cast<void>(finish()); }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  struct Topic {
    BagTopic known;
    const msgs::MessageType* type = nullptr;
    std::uint64_t bytes = 0;
    std::uint64_t lost = 0;  ///< The disk was too slow.
  };
  /// Returns the topic's number. A topic is one by its name and type.
  std::size_t add_topic(const std::string& name, const msgs::MessageType& type, std::vector<QoS> offered);
  [[nodiscard]] const std::vector<Topic>& topics() const { return topics_; }

  /// Encodes a message of the topic with this number into the open chunk. Times are nanoseconds since the Unix epoch: when it came, and when it
  /// was published. Does nothing once the recording has ended.
  void write(std::size_t index, const void* message, std::uint64_t log_time, std::uint64_t publish_time);
  /// Closes a chunk that is a second old. To be called several times a second.
  void look_at_time(MonotonicTime now);
  /// Waits until the disk has the chunks that are closed.
  void flush() { disk_.drain(); }
  /// Continues in another file. Errors: problem() says which.
  void split();

  /// Completes the last file, waits until the disk has it, and writes metadata.yaml. Returns problem(). A second call does nothing.
  std::optional<Problem> finish();

  /// Returns why the recording has ended, if it has: the disk is full, or does not take the bytes.
  [[nodiscard]] const std::optional<Problem>& problem() const { return problem_; }
  [[nodiscard]] const std::string& folder() const { return options_.folder; }
  [[nodiscard]] const std::string& file() const { return path_; }
  [[nodiscard]] std::size_t files() const { return metadata_.files.size(); }
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] std::uint64_t messages() const { return messages_; }

 private:
  explicit Recording(RecordingOptions options);
  [[nodiscard]] std::optional<Problem> open_file();
  void close_file();
  void end(Problem problem);
  [[nodiscard]] bool has_space();
  [[nodiscard]] std::uint16_t channel_of(std::size_t index);

  const RecordingOptions options_;
  DiskQueue disk_;
  std::vector<Topic> topics_;
  std::vector<std::optional<std::uint16_t>> channels_;  // of the open file, by topic
  BagMetadata metadata_;
  std::string path_;
  std::unique_ptr<QueuedFile> sink_;
  std::unique_ptr<McapWriter> writer_;  // of the open file; null: the recording has ended
  std::uint64_t earlier_bytes_ = 0, messages_ = 0;
  MonotonicTime now_{}, chunk_begun_{};
  std::optional<Problem> problem_;
  bool is_finished_ = false;
};

}  // namespace nacelle::record
