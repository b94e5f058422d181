// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include "nacelle/base/histogram.hpp"
#include "nacelle/node/transport.hpp"
#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

/// One reader's queue. Shared by the handle that the node owns and the writers that still list it.
/// Threads: any; the ring is reached under its lock.
class ReaderQueue {
 public:
  ReaderQueue(EndpointSpec spec, Taking taking, ReadyListener* listener);
  ~ReaderQueue();

  enum class Push : std::uint8_t { Queued, Full, Inactive };
  /// Takes over one reference.
  Push push(Block& block);
  [[nodiscard]] Block* take();
  [[nodiscard]] bool has_waiting() const { return waiting_.load(std::memory_order_acquire) != 0; }
  void set_enabled(bool enabled);
  /// No message and no listener any more; what waits is dropped and counted.
  void close();
  void note_latency(Duration latency) { latency_.record(latency); }
  void note_rehomed();

  [[nodiscard]] ReaderCounters counters() const;
  [[nodiscard]] const DurationHistogram& latency() const { return latency_; }
  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }
  [[nodiscard]] Taking taking() const { return taking_; }
  [[nodiscard]] bool wants_history() const { return wants_history_; }
  [[nodiscard]] bool is_enabled() const;
  /// The last sequence that this reader got from a writer, if it asks for history; else 0.
  [[nodiscard]] std::uint64_t seen(std::uint64_t writer) const;
  /// The writer is gone for good; what is remembered of it would add up over reloads.
  void forget_writer(std::uint64_t writer);

 private:
  void note_seen(const MessageInfo& info);
  void drop_all(std::uint64_t ReaderCounters::*cause);

  const EndpointSpec spec_;
  const Taking taking_;
  const bool keep_all_;
  const bool wants_history_;
  mutable FutexMutex mutex_;
  std::vector<Block*> ring_;
  std::size_t limit_;
  std::size_t head_ = 0;
  std::atomic<std::size_t> waiting_{0};
  bool enabled_;
  bool closed_ = false;
  ReadyListener* listener_;
  ReaderCounters counters_;
  DurationHistogram latency_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> seen_;
};

}  // namespace nacelle::runtime
