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

/// Lets a test wait for notifications of brokers and mirrors. Figures, which have no notification, are polled every few
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

/// One of several mirrors of this process that meet on the loopback interface. Null, and a failed test, if there is none to be had.
[[nodiscard]] inline std::unique_ptr<DdsMirror> start_mirror(Graph& graph, const Clock& clock, MirrorOptions options) {
  static std::uint32_t next = 1000000;  // in this process; on the network they share test_domain()
  options.domain_id = next++;
  options.config = loopback_config(test_domain());
  auto made = DdsMirror::start(graph, clock, std::move(options));
  if (made) return std::move(*made);
  ADD_FAILURE() << made.error().text();
  return nullptr;
}

/// A container's graph with its mirror: one of several on a network.
class MirroredBroker {
 public:
  explicit MirroredBroker(const std::string& name, std::vector<transport_dds::ExportRule> exports = {}) : name_(name) {
    MirrorOptions options;
    options.exports = std::move(exports);
    options.on_problem = [this](const Problem& problem) {
      problems.lock()->push_back(problem.text());
      bell.ring();
    };
    mirror = start_mirror(broker, clock, std::move(options));
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

/// Two graphs in one process that only the network joins.
class Mirror : public ::testing::Test {
 public:
  /// Either side's bell may ring for what the test waits for; figures of both are looked at.
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return here.bell.until(holds);
  }
  /// The writer's messages reach the reader from now on.
  [[nodiscard]] bool joined(const Writer& writer, const Reader& reader) {
    return until([&] { return writer.reader_count() == 1 && reader.writer_count() == 1; });
  }

  MirroredBroker here{"talker"}, there{"listener"};
};

}  // namespace nacelle::test
