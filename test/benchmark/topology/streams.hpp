// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "nacelle/node/node.hpp"
#include "topology/graph.hpp"

namespace nacelle::bench {

/// What the readers have seen. One writing thread; figures are differences of two looks.
class Tally {
 public:
  struct Look {
    std::uint64_t published = 0, delivered = 0, late = 0, too_late = 0, lost = 0;
  };
  void published() { bump(published_); }
  void delivered(Duration latency, Duration period, std::uint64_t skipped) {
    bump(delivered_);
    // As the topologies' authors count (data/topologies/README.md).
    if (latency > std::min<Duration>(period / 5, 5ms)) bump(late_);
    if (latency > std::min<Duration>(period, 50ms)) bump(too_late_);
    bump(lost_, skipped);
  }
  [[nodiscard]] Look look() const { return {published_, delivered_, late_, too_late_, lost_}; }

 private:
  using Count = std::atomic<std::uint64_t>;
  static void bump(Count& count, std::uint64_t by = 1) {
    count.store(count.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
  }
  Count published_{0}, delivered_{0}, late_{0}, too_late_{0}, lost_{0};
};

/// One reader's callback: the same in the container and in the bare program.
struct ReaderState {
  Tally* tally = nullptr;
  const Clock* clock = nullptr;
  Duration period{};
  std::uint64_t last = 0;
  void on_message(MonotonicTime source_time, std::uint64_t sequence) {
    const std::uint64_t skipped = last == 0 ? 0 : sequence - last - 1;
    last = sequence;
    tally->delivered(clock->now() - source_time, period, skipped);
  }
};

/// A message of the bare program, sent by filling it in place.
class BareMessage {
 public:
  virtual ~BareMessage() = default;
  virtual void fill() = 0;
};

/// The word of a type in a graph: `bytes` or a ROS 2 name such as sensor_msgs/msg/Image.
class StreamType {
 public:
  virtual ~StreamType() = default;
  /// A publisher and the timer that drives it.
  [[nodiscard]] virtual std::shared_ptr<void> make_source(Node& node, const Source& source, Tally& tally) const = 0;
  /// `state` outlives the node.
  [[nodiscard]] virtual std::shared_ptr<void> make_sink(Node& node, const Sink& sink, ReaderState& state) const = 0;
  [[nodiscard]] virtual std::unique_ptr<BareMessage> make_bare(const Source& source) const = 0;
  [[nodiscard]] virtual const msgs::MessageType& type() const = 0;
};

/// Errors: an unknown name ends the program with code 2.
[[nodiscard]] const StreamType& stream_type(const std::string& name);

}  // namespace nacelle::bench
