// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "record/model/ordered_messages.hpp"

namespace nacelle::replay {

struct InputFigures {
  std::uint64_t played = 0;     ///< Messages that were published.
  std::uint64_t unread = 0;     ///< Had no reader, so that they were not decoded.
  std::uint64_t undecoded = 0;  ///< Are no message of their type.
};

/// The messages of a recording, published one after the other in the order of their log times.
///
/// A topic has the QoS that it was recorded with.
/// Topics that running components publish are left to them. Of transforms that is true frame by frame: those of children that running components
/// claim are taken out of recorded messages.
/// Threads: one. The recording and the transport outlive it.
class RecordedInputs {
 public:
  /// Returns the type of that name; null if it is not installed.
  using FindType = std::function<const msgs::MessageType*(const std::string& name)>;
  /// `published`: the topics that components here publish.
  RecordedInputs(record::OrderedMessages& recording, Transport& transport, const FindType& find_type,
                 const std::set<std::string>& published);

  /// Leaves out the transforms of these children.
  void leave_out_frames(std::set<std::string> children) { claimed_ = std::move(children); }
  /// Returns the topics that are not played although no component here publishes them, each with the reason.
  [[nodiscard]] const std::vector<std::string>& refused() const { return refused_; }
  /// Returns whether this is the id of one of its writers.
  [[nodiscard]] bool is_mine(std::uint64_t writer) const { return ids_.contains(writer); }

  /// Returns the next message, which publish_next() will publish; null at the end.
  [[nodiscard]] const record::OrderedMessages::Message* next() const { return next_; }
  /// Returns its time.
  [[nodiscard]] WallTime next_time() const { return WallTime{Duration{static_cast<Duration::rep>(next_->log_time)}}; }
  /// Returns whether the next message is of a topic that is played.
  [[nodiscard]] bool next_is_played() const { return topics_[next_->topic].writer != nullptr; }
  /// Returns whether the next message is played, and not for nothing.
  [[nodiscard]] bool next_has_reader() const {
    const Topic& topic = topics_[next_->topic];
    return topic.writer != nullptr && (topic.keeps || topic.writer->reader_count() > 0);
  }
  void publish_next();
  [[nodiscard]] const InputFigures& figures() const { return figures_; }

 private:
  struct Topic {
    const msgs::MessageType* type = nullptr;
    Writer* writer = nullptr;  ///< Null: it is not played.
    bool keeps = false;        ///< For late readers.
    bool is_shared = false;    ///< Running components publish it too.
  };
  void add(const record::OrderedMessages::Topic& recorded, Transport& transport, const FindType& find_type,
           const std::set<std::string>& published);
  [[nodiscard]] bool decode_next(const Topic& topic, void* message);

  record::OrderedMessages& recording_;
  std::vector<Topic> topics_;  // as in the recording
  std::vector<std::unique_ptr<Writer>> writers_;
  std::set<std::uint64_t> ids_;
  std::set<std::string> claimed_;
  std::vector<std::string> refused_;
  const record::OrderedMessages::Message* next_ = nullptr;
  InputFigures figures_;
};

}  // namespace nacelle::replay
