// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/histogram.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/host/graph.hpp"
#include "nacelle/qos/compatibility.hpp"
#include "nacelle/runtime/container.hpp"
#include "reader_queue.hpp"

namespace nacelle::runtime {

class BrokerWriter;

/// The writers and readers of one name and type. Lock order: broker, topic, a writer's contract or a reader's queue,
/// then the locks of listeners.
class Topic {
 public:
  Topic(std::string name, const msgs::MessageType& type) : name_(std::move(name)), type_(type) {}

  struct Totals {
    WriterCounters written;
    ReaderCounters read;
    std::unique_ptr<DurationHistogram> latency;
    std::uint64_t first_ns = 0, last_ns = 0;
    HandedOver handed_over = HandedOver::Never;
  };

  /// For the compiler's analysis: the caller holds the topic's lock, under another name.
  void assume_locked() const NACELLE_ASSERTS_HELD(mutex_) {}

  const std::string name_;
  const msgs::MessageType& type_;
  std::atomic<std::uint64_t> version_{1};
  mutable Mutex mutex_;
  std::vector<BrokerWriter*> writers_ NACELLE_GUARDED_BY(mutex_);
  std::vector<std::shared_ptr<ReaderQueue>> readers_ NACELLE_GUARDED_BY(mutex_);
  Totals gone_ NACELLE_GUARDED_BY(mutex_);  // of endpoints that were removed
  // Under the broker's lock: its place among the topics without an endpoint.
  std::optional<std::list<Topic*>::iterator> place_unused_;
};

/// Returns true for an endpoint of a tool (topic echo), which must not change the figures of the robot's own streams.
inline bool is_tool(const EndpointSpec& spec) { return spec.node.empty(); }

/// Returns true if both are proxies for endpoints of the same other process, which connects them itself.
inline bool same_link(const EndpointSpec& writer, const EndpointSpec& reader) {
  return writer.via != 0 && writer.via == reader.via;
}

/// Returns true if another reader of its node reads this writer (EndpointSpec::unless_offered).
inline bool leaves_to_another(const EndpointSpec& reader, const EndpointSpec& writer) {
  return reader.unless_offered &&
         verdict_of(writer.qos.resolved(), reader.unless_offered->resolved()) != Verdict::Error;
}

inline bool matches(const EndpointSpec& writer, const EndpointSpec& reader) {
  return !same_link(writer, reader) && verdict_of(writer.qos.resolved(), reader.qos.resolved()) != Verdict::Error &&
         !leaves_to_another(reader, writer);
}

void add(ReaderCounters& to, const ReaderCounters& more);
/// Returns how the topic's messages passed between threads, also those of removed endpoints. Under the topic's lock.
[[nodiscard]] HandedOver handed_over(const Topic& topic) NACELLE_REQUIRES(topic.mutex_);
[[nodiscard]] EndpointInfo info_of(const EndpointSpec& spec, std::uint64_t id, bool is_writer, bool open);

}  // namespace nacelle::runtime
