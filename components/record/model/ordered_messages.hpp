// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <queue>
#include <string>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "record/protocol/mcap_walk.hpp"

namespace nacelle::record {

/// Hands over the messages of several MCAP files in the order of their log times. Messages of one time come in the order in which they were
/// written.
///
/// It reads the summaries first (of a file without one, all), and later each chunk when its time has come, so that it holds as many chunks as
/// overlap, up to 1 GiB of them.
/// The sources outlive it. Threads: one. Times are nanoseconds since the Unix epoch.
class OrderedMessages {
 public:
  struct Topic {
    std::string name, type;  ///< "/scan", "sensor_msgs/msg/LaserScan"; the type is "" for a channel without a schema.
    std::string message_encoding, schema_encoding, definition;
    std::map<std::string, std::string> metadata;
    friend bool operator==(const Topic&, const Topic&) = default;
  };
  struct Message {
    std::size_t topic = 0;
    std::uint64_t log_time = 0, publish_time = 0;
    std::uint32_t sequence = 0;
    ByteView data;  ///< Valid until the next call.
  };
  /// A problem of the file with this number.
  struct FileProblem {
    std::size_t file = 0;
    McapProblem problem;
  };

  /// Errors: a file without an end, or whose summary is damaged. Such a file can be recovered.
  [[nodiscard]] static Result<std::unique_ptr<OrderedMessages>, FileProblem> open(
      const std::vector<ByteSource*>& files);
  ~OrderedMessages();
  OrderedMessages(const OrderedMessages&) = delete;
  OrderedMessages& operator=(const OrderedMessages&) = delete;

  /// Equal channels of several files are one topic.
  [[nodiscard]] const std::vector<Topic>& topics() const { return topics_; }
  /// Of the first and the last message, as the summaries say; 0 if there is none.
  [[nodiscard]] std::uint64_t first() const { return first_; }
  [[nodiscard]] std::uint64_t last() const { return last_; }
  [[nodiscard]] std::uint64_t messages() const { return messages_; }

  /// Returns the next message; null at the end, and after a problem.
  [[nodiscard]] const Message* next();
  /// Continues with the first message at this time or later.
  void seek(std::uint64_t time);
  /// Returns what could not be read; the messages of such a chunk are left out.
  [[nodiscard]] const std::vector<FileProblem>& problems() const { return problems_; }

 private:
  class File;
  struct Chunk {
    std::uint64_t start = 0, end = 0;
    std::size_t file = 0;
    std::uint64_t offset = 0, length = 0;
  };
  struct Waiting {
    std::uint64_t log_time = 0, number = 0;  // the order in which they were read
    std::shared_ptr<const Bytes> bytes;      // of the whole chunk
    std::size_t offset = 0, size = 0;
    std::size_t topic = 0;
    std::uint64_t publish_time = 0;
    std::uint32_t sequence = 0;
    friend bool operator>(const Waiting& a, const Waiting& b) {
      return a.log_time != b.log_time ? a.log_time > b.log_time : a.number > b.number;
    }
  };
  OrderedMessages() = default;
  void load_until(std::uint64_t time);
  void note_problem(std::size_t file, const McapProblem& problem);
  std::size_t topic_of(Topic topic);

  std::vector<std::unique_ptr<File>> files_;
  std::vector<Chunk> chunks_;  // by their start
  std::size_t next_chunk_ = 0;
  std::vector<Topic> topics_;
  std::uint64_t first_ = 0, last_ = 0, messages_ = 0, from_ = 0, numbered_ = 0;
  std::uint64_t held_ = 0;  // bytes of chunks
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> waiting_;
  Waiting current_;
  Message message_;
  std::vector<FileProblem> problems_;
};

}  // namespace nacelle::record
