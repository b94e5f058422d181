// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "record/component/message_log.hpp"
#include "record/component/recording.hpp"
#include "record/model/byte_file.hpp"
#include "record/port/ring_folder.hpp"

namespace nacelle::record {

struct RingOptions {
  std::string base = "/dev/shm";
  std::string name;                           ///< Of the folder; see ring_name().
  Duration longest = 60s;                     ///< Older chunks go.
  std::uint64_t most_bytes = 64 * kMegabyte;  ///< Above it the oldest chunks go.
  Compression compression = Compression::None;
  std::uint64_t soon_free = 0;  ///< Bytes that rings of killed processes still take there.
};

/// Keeps the last seconds of messages in memory, which outlives a killed process.
///
/// Each chunk, of 1 s or 1 MiB, is an MCAP file of its own without a summary, in a folder of /dev/shm. The oldest one goes when there are too many
/// bytes or seconds, or when /dev/shm is full. What publishers keep for late readers (all publishers of the topic are transient_local) is
/// kept beside the chunks in up to half of the bytes, as many messages of each publisher as it keeps itself.
/// Threads: one. Errors: of begin(), there is no /dev/shm or it is full; later ones, that not one chunk can be stored, are in problem().
class Ring final : public MessageLog {
 public:
  /// Takes at most half of what /dev/shm has free, or soon will: other programs need it, too. most_bytes() says how much.
  [[nodiscard]] static Result<std::unique_ptr<Ring>, Problem> begin(RingOptions options);
  ~Ring() override = default;

  void write(std::size_t index, const void* message, const MessageStamps& stamps) override;
  /// Each snapshot has it, up to a quarter of the bytes.
  void attach(const RunText& text, std::uint64_t time) override;
  void look_at_time(MonotonicTime now) override;
  void split() override {}
  /// What is there stays until the ring is destroyed, or as long as a snapshot holds it.
  std::optional<Problem> finish() override { return problem_; }

  [[nodiscard]] const std::string& folder() const override { return folder_->path(); }
  [[nodiscard]] const std::string& file() const override { return file_; }
  [[nodiscard]] std::size_t files() const override { return chunks_.size() + kept_.size() + attached_.size(); }
  /// Those that are in memory now.
  [[nodiscard]] std::uint64_t bytes() const override { return stored() + writer_.pending(); }
  [[nodiscard]] std::optional<Duration> reach() const override;
  [[nodiscard]] std::uint64_t most_bytes() const { return options_.most_bytes; }

  using Files = std::vector<std::shared_ptr<const RingFile>>;
  /// Closes the open chunk, and returns what is there. It stays as long as the caller holds it, while the ring goes on.
  [[nodiscard]] Files content();

 private:
  class Memory final : public ByteSink {
   public:
    [[nodiscard]] bool write(ByteView more) override {
      bytes.insert(bytes.end(), more.begin(), more.end());
      return true;
    }
    Bytes bytes;
  };
  struct Chunk {
    std::shared_ptr<const RingFile> file;
    MonotonicTime begun, closed;
  };
  struct Kept {
    std::shared_ptr<const RingFile> file;
    std::size_t topic = 0;
    std::uint64_t writer = 0;
  };
  Ring(RingOptions options, std::shared_ptr<RingFolder> folder);
  [[nodiscard]] std::uint64_t stored() const { return bytes_ + kept_bytes_ + attached_bytes_; }
  void store();
  void keep(std::size_t index, const void* message, const MessageStamps& stamps, std::uint64_t chunk);
  void forget_kept(const std::deque<Kept>::iterator& which);
  void drop_oldest();
  [[nodiscard]] std::shared_ptr<const RingFile> add(const std::string& name, ByteView bytes);

  const RingOptions options_;
  const std::shared_ptr<RingFolder> folder_;
  Memory memory_, kept_memory_;
  McapWriter writer_, kept_writer_;
  std::deque<Chunk> chunks_;
  std::deque<Kept> kept_;
  std::vector<std::shared_ptr<const RingFile>> attached_;
  std::uint64_t next_ = 0, next_kept_ = 0;  // numbers
  std::uint64_t bytes_ = 0, kept_bytes_ = 0, attached_bytes_ = 0;
  MonotonicTime now_{}, chunk_begun_{};
  const std::string file_;
};

/// The names of the ring's files, by the number of the chunk and of the kept message.
[[nodiscard]] std::string chunk_name(std::uint64_t chunk);
[[nodiscard]] std::string kept_name(std::uint64_t kept, std::uint64_t chunk);
[[nodiscard]] std::string attached_name(std::uint64_t attached);
/// Returns the files that belong into a snapshot, in its order: attachments, kept messages whose chunk is not there, then the chunks. Files with other names
/// are left out.
[[nodiscard]] std::vector<std::string> in_ring_order(std::vector<std::string> paths);

}  // namespace nacelle::record
