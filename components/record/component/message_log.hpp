// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/node/container_facts.hpp"
#include "record/model/bag_metadata.hpp"
#include "record/protocol/mcap_writer.hpp"

namespace nacelle::record {

/// When a message came and was published, in nanoseconds since the Unix epoch, and by which publisher of the container.
struct MessageStamps {
  std::uint64_t log_time = 0, publish_time = 0;
  std::uint64_t writer = 0;  ///< MessageInfo::writer_id.
};

/// What a recorder writes messages into: a recording that grows on the disk (Recording), or the last seconds in memory (Ring).
///
/// Threads: one.
class MessageLog {
 public:
  MessageLog() = default;
  MessageLog(const MessageLog&) = delete;
  MessageLog& operator=(const MessageLog&) = delete;
  virtual ~MessageLog() = default;

  struct Topic {
    BagTopic known;
    const msgs::MessageType* type = nullptr;
    std::uint64_t bytes = 0;
    std::uint64_t lost = 0;  ///< The disk was too slow, or the memory is too small.
  };
  /// Returns the topic's number. A topic is one by its name and type.
  std::size_t add_topic(const std::string& name, const msgs::MessageType& type, std::vector<QoS> offered);
  [[nodiscard]] const std::vector<Topic>& topics() const { return topics_; }

  /// Encodes a message of the topic with this number. Does nothing once the log has ended.
  virtual void write(std::size_t index, const void* message, const MessageStamps& stamps) = 0;
  /// Adds a file that belongs to the recording, as one that came at `time` (as a log time).
  virtual void attach(const RunText& text, std::uint64_t time) = 0;
  /// Closes a chunk that is a second old. To be called several times a second.
  virtual void look_at_time(MonotonicTime now) = 0;
  /// Continues in another file, where there are files.
  virtual void split() = 0;
  /// Keeps words about the whole log (what was lost) for its end; later ones replace earlier ones.
  virtual void say_at_end(const std::map<std::string, std::string>& words) { static_cast<void>(words); }
  /// Completes what there is to complete. Returns problem(). A second call does nothing.
  virtual std::optional<Problem> finish() = 0;

  /// Returns why the log has ended by itself, if it has.
  [[nodiscard]] const std::optional<Problem>& problem() const { return problem_; }
  [[nodiscard]] virtual const std::string& folder() const = 0;
  [[nodiscard]] virtual const std::string& file() const = 0;
  [[nodiscard]] virtual std::size_t files() const = 0;
  [[nodiscard]] virtual std::uint64_t bytes() const = 0;
  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  /// Returns how long ago the oldest message came that is still there; nothing if all are.
  [[nodiscard]] virtual std::optional<Duration> reach() const { return std::nullopt; }

 protected:
  /// Counts a message of that many bytes.
  void count(Topic& topic, std::size_t size);

  std::vector<Topic> topics_;
  std::uint64_t messages_ = 0;
  std::optional<Problem> problem_;
};

/// Returns the id of the topic's channel in a file, as rosbag2 describes it. Errors: nullopt if the file cannot have more.
[[nodiscard]] std::optional<std::uint16_t> channel_of(const MessageLog::Topic& topic, McapWriter& writer);

/// Writes an attachment. Errors: false if the sink failed.
[[nodiscard]] bool write_attachment(const RunText& text, std::uint64_t time, McapWriter& writer);

}  // namespace nacelle::record
