// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/runtime/broker.hpp"
#include "nacelle/transport_dds/mirror.hpp"
#include "support/dds.hpp"
#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::test {

using std_msgs::msg::String;
using Texts = std::vector<std::string>;

/// Lets a test wait for what brokers and mirrors tell; what nobody tells of (figures) is looked at every few
/// milliseconds.
/// Threads: any.
class Bell final : public StatusListener, public ReadyListener {
 public:
  void on_status() noexcept override { ring(); }
  void on_ready() noexcept override { ring(); }
  void ring() noexcept {
    const std::lock_guard lock(mutex_);
    ++rung_;
    condition_.notify_all();
  }
  /// True once `holds` does; false after thirty seconds.
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    const auto limit = std::chrono::steady_clock::now() + 30s;
    for (;;) {
      std::unique_lock lock(mutex_);
      const std::uint64_t seen = rung_;
      lock.unlock();
      if (holds()) return true;
      if (std::chrono::steady_clock::now() > limit) return false;
      lock.lock();
      condition_.wait_for(lock, 5ms, [&] { return rung_ != seen; });
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable condition_;
  std::uint64_t rung_ = 0;
};

/// A container's graph with its mirror: one of several on a network.
class MirroredBroker {
 public:
  explicit MirroredBroker(const std::string& name, std::vector<transport_dds::ExportRule> exports = {}) : name_(name) {
    static std::uint32_t next = 0;  // in this process; on the network they share test_domain()
    MirrorOptions options;
    options.domain_id = 1000000 + next++;
    options.config = loopback_config(test_domain());
    options.exports = std::move(exports);
    options.on_problem = [this](const Problem& problem) {
      problems.lock()->push_back(problem.text());
      bell.ring();
    };
    auto made = DdsMirror::start(broker, clock, options);
    if (!made) ADD_FAILURE() << name << ": " << made.error().text();
    if (made) mirror = std::move(*made);
  }
  [[nodiscard]] EndpointSpec spec(const std::string& topic, const QoS& qos = QoS(10)) {
    EndpointSpec spec{topic, &String::message_type(), qos, "/" + name_};
    spec.status_listener = &bell;
    return spec;
  }
  [[nodiscard]] std::unique_ptr<Writer> writer(const std::string& topic, const QoS& qos = QoS(10)) {
    return broker.create_writer(spec(topic, qos));
  }
  [[nodiscard]] std::unique_ptr<Reader> reader(const std::string& topic, const QoS& qos = QoS(10),
                                               Taking taking = Taking::Share) {
    return broker.create_reader(spec(topic, qos), taking, &bell);
  }
  [[nodiscard]] MirrorStats stats() const { return mirror->stats(); }

  const SystemClock clock;
  Bell bell;
  Guarded<Texts> problems;
  runtime::Broker broker{clock, runtime::Watching::ByThread};
  std::unique_ptr<DdsMirror> mirror;

 private:
  const std::string name_;
};

inline PublishResult say(Writer& writer, const std::string& text) {
  Block* const block = writer.borrow();
  static_cast<String*>(block->message)->data = text;
  return writer.publish(*block);
}

/// All that waits.
inline Texts hear(Reader& reader) {
  Texts all;
  while (Block* const block = reader.take()) {
    all.push_back(static_cast<const String*>(block->message)->data);
    drop_reference(*block);
  }
  return all;
}

/// Takes until there are so many.
inline Texts hear(Bell& bell, Reader& reader, std::size_t count) {
  Texts all;
  static_cast<void>(bell.until([&] {
    for (auto& text : hear(reader)) all.push_back(std::move(text));
    return all.size() >= count;
  }));
  return all;
}

}  // namespace nacelle::test
