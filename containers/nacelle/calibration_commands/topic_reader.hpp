// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "calibration_commands/dialogue.hpp"
#include "control/client.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::cli {

/// Reads the messages of a topic of a running container as JSON; only those that are published after it was made.
///
/// Threads: one.
class TopicReader {
 public:
  /// Errors: an exit code; the error has been printed: no container, no such topic.
  [[nodiscard]] static Result<TopicReader, int> open(const std::string& container, const std::string& topic);

  /// Returns the next message that is here already, or nothing. Errors: the container has ended.
  [[nodiscard]] Result<std::optional<nlohmann::json>, Problem> take();
  /// Becomes readable when take() may have a message.
  [[nodiscard]] int descriptor() const { return client_.descriptor(); }
  [[nodiscard]] const std::string& topic() const { return topic_; }

 private:
  TopicReader(control::Client client, std::string topic) : client_(std::move(client)), topic_(std::move(topic)) {}

  control::Client client_;
  std::string topic_;
};

/// Waits for the next message. Errors: an exit code, printed: a signal; no message for `silence`; the container has ended.
[[nodiscard]] Result<nlohmann::json, int> next_message(const Dialogue& dialogue, TopicReader& reader, Duration silence);

/// Passes messages of a topic to `take` until it returns false. Returns kDone, or the exit code of an error, which has been
/// printed: as TopicReader::open() and next_message().
[[nodiscard]] int collect(const Dialogue& dialogue, const std::string& container, const std::string& topic,
                          Duration silence, const std::function<bool(const nlohmann::json&)>& take);

}  // namespace nacelle::cli
