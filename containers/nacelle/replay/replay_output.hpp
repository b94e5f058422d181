// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "record/model/ordered_messages.hpp"
#include "record/protocol/mcap_writer.hpp"

namespace nacelle::replay {

/// Writes what is published into an MCAP file, in its order, with the clock's time.
///
/// Nothing in the file depends on real time, on the process or on the file's name: the same messages at the same times are the same bytes.
/// Threads: one, which is also the publishers'. The sink, the transport and the clock outlive it.
class ReplayOutput {
 public:
  /// `is_input`: whether the writer with this id is the recording's, whose messages are not written.
  ReplayOutput(record::ByteSink& sink, record::Compression compression, Transport& transport, const Clock& clock,
               std::function<bool(std::uint64_t writer)> is_input);
  ~ReplayOutput();
  ReplayOutput(const ReplayOutput&) = delete;
  ReplayOutput& operator=(const ReplayOutput&) = delete;

  /// Writes what is published on a topic from now on, and what its publishers kept. A second call does nothing.
  void add(const std::string& topic, const msgs::MessageType& type, const std::vector<QoS>& offered);
  /// Writes a message of a recording as it is; `topic` is what its number stands for, always the same one.
  void write(const record::OrderedMessages::Topic& topic, const record::OrderedMessages::Message& message);
  /// Completes the file. Returns false if the sink has not taken everything; its problem() says why.
  [[nodiscard]] bool finish();

  /// Messages of publishers, by topic.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& messages() const { return messages_; }
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  struct Stream;
  void take(Stream& stream);

  record::McapWriter writer_;
  Transport& transport_;
  const Clock& clock_;
  const std::function<bool(std::uint64_t)> is_input_;
  std::map<std::size_t, std::uint16_t> channels_;  // of the recording's topics
  std::map<std::string, std::uint64_t> messages_;
  bool has_failed_ = false;
  std::map<std::string, std::unique_ptr<Stream>> streams_;  // last: their readers call take()
};

}  // namespace nacelle::replay
