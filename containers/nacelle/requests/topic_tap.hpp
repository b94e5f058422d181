// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nacelle/base/bell.hpp"
#include "nacelle/host/transport.hpp"

namespace nacelle::requests {

/// A tool's reader of a topic. It does not count as a reader of the stream in the report.
///
/// Errors: std::system_error if the process has no descriptor left.
/// Threads: one, except for the writers' wake-up.
class TopicTap final : private ReadyListener {
 public:
  /// Reads with best effort, and never delays a writer. If all present writers keep a history (transient_local), it
  /// also receives their older messages.
  TopicTap(Transport& transport, const std::string& topic, const msgs::MessageType& type, std::size_t depth);
  /// Reads with the QoS of `spec`, for a caller that knows the writers' QoS.
  TopicTap(Transport& transport, const EndpointSpec& spec);
  TopicTap(const TopicTap&) = delete;
  TopicTap& operator=(const TopicTap&) = delete;
  ~TopicTap() override;

  /// Returns a descriptor that is readable when take() may have a message.
  [[nodiscard]] int descriptor() const { return event_.descriptor(); }
  /// Returns the next message, or null. Call it until it returns null. The caller returns the block with
  /// drop_reference().
  [[nodiscard]] Block* take();
  [[nodiscard]] const std::string& topic() const { return topic_; }
  [[nodiscard]] const msgs::MessageType& type() const { return type_; }
  [[nodiscard]] std::size_t writer_count() const { return reader_->writer_count(); }

 private:
  void on_ready() noexcept override;

  const std::string topic_;
  const msgs::MessageType& type_;
  Bell event_;
  std::unique_ptr<Reader> reader_;
};

}  // namespace nacelle::requests
