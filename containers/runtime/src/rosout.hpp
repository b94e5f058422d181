// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>

#include "log_queue.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/runtime/callback_group.hpp"

namespace nacelle::runtime {

/// Publishes the log on /rosout (rcl_interfaces/msg/Log), each line by the writer of the node whose logger has written
/// it; other lines are published by the container's node. The logging thread only leaves a copy of the line; the
/// group's executor publishes it.
///
/// Threads: any.
class Rosout final : LogListener, Executable {
 public:
  /// `own_node` publishes the lines that belong to no other node.
  Rosout(CallbackGroup& group, Transport& transport, const Clock& clock, const std::string& own_node);
  ~Rosout() override;
  Rosout(const Rosout&) = delete;
  Rosout& operator=(const Rosout&) = delete;

  /// Adds a writer for a node. From now on lines of its logger are published by it.
  void add(const std::string& node);
  /// Publishes all lines logged so far, and removes the node's writer.
  void remove(const std::string& node);
  /// Returns the number of lines that were dropped so far because the queue was full.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  using Writers = std::map<std::string, std::unique_ptr<Writer>, std::less<>>;
  void on_line(LogLevel level, std::string_view name, std::string_view text, const LogPlace& place) noexcept override;
  void execute(MonotonicTime now) override;
  void publish_all(Writers& writers);
  [[nodiscard]] std::unique_ptr<Writer> make_writer(const std::string& node) const;

  Transport& transport_;
  const Clock& clock_;
  const std::string own_name_;
  LogQueue queue_;
  Guarded<Writers> writers_;  // by the logger's name
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace nacelle::runtime
