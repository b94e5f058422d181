// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include "contract.hpp"
#include "nacelle/base/histogram.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/runtime/executor.hpp"
#include "nacelle/runtime/futex.hpp"
#include "nacelle/runtime/graph_watch.hpp"
#include "nacelle/runtime/reports.hpp"
#include "qos_watch.hpp"
#include "this_thread.hpp"

namespace nacelle::runtime {

/// The policy name in the report of a type clash.
inline constexpr const char* kTypePolicy = "type";

/// The queue of one reader. Ownership: shared by the node's handle and the writers that still list it.
///
/// The queue of an executable is guarded by its executor's lock: a message is pushed and its executable queued, or a
/// message is taken and its executable started, under one hold of the lock. The queue of any other listener has its own
/// lock.
/// Threads: any. The ring is accessed under its lock.
class ReaderQueue {
 public:
  ReaderQueue(EndpointSpec spec, Taking taking, ReadyListener* listener, const Clock& clock, QosWatch* qos_watch,
              std::uint64_t id);
  /// Makes the executable take its messages from this queue.
  ReaderQueue(EndpointSpec spec, Taking taking, Executable& executable, const Clock& clock, QosWatch* qos_watch,
              std::uint64_t id);
  ~ReaderQueue();

  enum class Push : std::uint8_t { Queued, Full, Inactive };
  [[nodiscard]] FutexMutex& mutex() const NACELLE_RETURNS_LOCK(*mutex_) { return *mutex_; }
  /// For the compiler's analysis: the caller holds mutex(), under another name (its executor's lock).
  void assume_locked() const NACELLE_ASSERTS_HELD(*mutex_) {}
  /// Queues a message and takes over one reference. Under the lock. `called` receives the word of a thread that must be
  /// woken when the lock is released; unchanged if there is none. Returns false, without effect, if the message needs
  /// more work: then call push() without the lock.
  [[nodiscard]] bool push_quickly(Block& block, const std::atomic<std::uint32_t>*& called) NACELLE_REQUIRES(*mutex_);
  /// Queues a message and takes over one reference.
  Push push(Block& block);
  [[nodiscard]] Block* take();
  /// Returns the oldest message if it needs no further work, under the lock; null: call take().
  [[nodiscard]] Block* take_quickly() NACELLE_REQUIRES(*mutex_);
  /// Waits until a full KEEP_ALL queue has room, at most until the deadline. Threads: none that runs callbacks.
  void wait_for_room(MonotonicTime deadline);
  /// Counts missed deadlines; returns when the next one is due.
  MonotonicTime watch(MonotonicTime now);
  [[nodiscard]] bool has_waiting() const { return waiting_.load(std::memory_order_acquire) != 0; }
  void set_enabled(bool enabled);
  /// Closes the queue: no message and no listener call any more. Waiting messages are dropped and counted.
  void close();
  void note_latency(Duration latency) {
    latency_.record(latency);
    thread_.store(this_thread_mark(), std::memory_order_relaxed);
  }
  /// Returns the last thread on which a callback got a message; 0: none yet.
  [[nodiscard]] std::uintptr_t thread() const { return thread_.load(std::memory_order_relaxed); }
  void note_rehomed();
  /// Sets the links to notify when a message leaves a KEEP_ALL queue. Call before the queue is shared.
  void tell_links(const GraphWatch* links) { links_ = keep_all_ ? links : nullptr; }

  // Call these before the queue is shared; see Graph.
  void be_tap_of(std::uint64_t writer) { tapped_ = writer; }
  void be_witness() { witness_ = true; }
  [[nodiscard]] bool is_tap() const { return tapped_ != 0; }
  [[nodiscard]] bool is_witness() const { return witness_; }
  [[nodiscard]] bool taps(std::uint64_t writer) const { return tapped_ == writer; }
  // For a witness, under the topic's lock.
  /// Sets whether this counts as a subscription of a writer (Witness::count_for()). Returns false if nothing changes.
  bool count_for(std::uint64_t writer, bool counts) {
    if (counts == is_counted_by(writer)) return false;
    return counts ? (counted_by_.push_back(writer), true) : std::erase(counted_by_, writer) != 0;
  }
  [[nodiscard]] bool is_counted_by(std::uint64_t writer) const {
    return std::ranges::find(counted_by_, writer) != counted_by_.end();
  }

  // For the proxy of a reader in another process; see ProxyReader (reader_proxy.cpp).
  [[nodiscard]] Block* look();
  void release(std::uint64_t messages);
  void forget_seen();
  // Under the topic's lock.
  void set_lender(std::shared_ptr<BufferLender> lender) { lender_ = std::move(lender); }
  [[nodiscard]] const std::shared_ptr<BufferLender>& lender() const { return lender_; }
  void note_lost(const ReaderCounters& losses);

  /// Records a writer that matched, or that is incompatible: changes the totals and notifies the listener.
  void note_matched();
  void note_clash(const std::string& policy, std::string text);
  /// Notifies the listener that a status that is computed on demand (liveliness, matched) has changed.
  void tell() const;

  /// Returns the totals; figures that depend on the present writers are zero.
  [[nodiscard]] EndpointStatus status() const;
  [[nodiscard]] ReaderCounters counters() const;
  /// Writes every field.
  void report(ReaderReport& row) const;
  [[nodiscard]] const DurationHistogram& latency() const { return latency_; }
  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }
  [[nodiscard]] std::uint64_t id() const { return id_; }
  [[nodiscard]] Taking taking() const { return taking_; }
  [[nodiscard]] bool keeps_all() const { return keep_all_; }
  [[nodiscard]] bool wants_history() const { return wants_history_; }
  [[nodiscard]] bool is_enabled() const;
  /// Returns the last sequence number that this reader got from a writer, if it requests history; else 0.
  [[nodiscard]] std::uint64_t seen(std::uint64_t writer) const;
  /// Forgets a writer that is destroyed; its data would otherwise accumulate over reloads.
  void forget_writer(std::uint64_t writer);

 private:
  /// Depends on the QoS only, so it needs no lock.
  [[nodiscard]] bool has_deadline() const NACELLE_NOT_CHECKED { return deadline_.is_set(); }
  void note_seen(const MessageInfo& info) NACELLE_REQUIRES(*mutex_);
  ReaderQueue(EndpointSpec&& spec, Taking taking, ReadyListener* listener, Executable* executable, const Clock& clock,
              QosWatch* qos_watch, std::uint64_t id);
  // Work to do after the lock is released.
  struct Loose {
    Block* evicted = nullptr;
    bool tell = false, poke = false;
  };
  Push push_locked(Block& block, Loose& loose, const std::atomic<std::uint32_t>*& called) NACELLE_REQUIRES(*mutex_);
  void append(Block& block, std::size_t waiting, const std::atomic<std::uint32_t>*& called) NACELLE_REQUIRES(*mutex_);
  void note_room() NACELLE_REQUIRES(*mutex_);
  void grow() NACELLE_REQUIRES(*mutex_);
  [[nodiscard]] std::size_t size() const NACELLE_REQUIRES(*mutex_) { return mask_ + 1; }
  void drop_all(std::uint64_t ReaderCounters::*cause);
  Block* pop() NACELLE_REQUIRES(*mutex_);
  Block* pop_unread() NACELLE_REQUIRES(*mutex_);
  void note_arrival(MonotonicTime now, Loose& loose) NACELLE_REQUIRES(*mutex_);

  const EndpointSpec spec_;
  const Taking taking_;
  const bool keep_all_;
  const bool wants_history_;
  // Shared: a writer that has not noticed yet that this queue is closed may use it after the executor is gone.
  const std::shared_ptr<FutexMutex> mutex_;
  Executor* const executor_;  // null, like the next member, for every listener that is not an executable
  Executable* executable_ NACELLE_GUARDED_BY(*mutex_);
  std::size_t mask_ NACELLE_GUARDED_BY(*mutex_);  // the ring's size, a power of two, minus one
  std::unique_ptr<Block*[]> ring_ NACELLE_GUARDED_BY(*mutex_);
  const std::size_t limit_;
  // Limit for push_quickly(); 0 if a push needs more than filling the ring.
  std::size_t room_ NACELLE_GUARDED_BY(*mutex_) = 0;
  std::size_t head_ NACELLE_GUARDED_BY(*mutex_) = 0;  // number of messages ever taken; masked, the index of the oldest
  std::atomic<std::size_t> waiting_{0};
  bool enabled_ NACELLE_GUARDED_BY(*mutex_);
  bool closed_ NACELLE_GUARDED_BY(*mutex_) = false;
  // Each listener is called under its own lock, so that close() can guarantee that the calls have ended. There are two
  // locks because a take() from within on_ready() may find an expired message and notify the other listener.
  FutexMutex listener_mutex_;
  ReadyListener* listener_ NACELLE_GUARDED_BY(listener_mutex_);
  mutable FutexMutex status_mutex_;
  StatusListener* status_listener_ NACELLE_GUARDED_BY(status_mutex_);
  const Clock& clock_;
  QosWatch* const qos_watch_;  // null: another thread calls watch() in time
  const std::uint64_t id_;
  DeadlineWatch deadline_ NACELLE_GUARDED_BY(*mutex_);
  EndpointStatus totals_ NACELLE_GUARDED_BY(*mutex_);
  std::atomic<std::uint32_t> room_word_{0};  // changes when a message leaves while a thread waits for room
  std::uint32_t room_waiters_ NACELLE_GUARDED_BY(*mutex_) = 0;
  ReaderCounters counters_ NACELLE_GUARDED_BY(*mutex_);   // except the figures that follow from head_ and waiting_
  std::uint64_t unread_ NACELLE_GUARDED_BY(*mutex_) = 0;  // taken, but not delivered
  DurationHistogram latency_;
  std::atomic<std::uintptr_t> thread_{0};
  std::vector<std::pair<std::uint64_t, std::uint64_t>> seen_ NACELLE_GUARDED_BY(*mutex_);
  const GraphWatch* links_ = nullptr;  // notified when a message from a link leaves a KEEP_ALL queue
  std::shared_ptr<BufferLender> lender_;
  std::uint64_t tapped_ = 0;  // the only writer that it reads; 0: it is not a tap
  bool witness_ = false;
  std::vector<std::uint64_t> counted_by_;                         // as a witness
  std::size_t looked_at_ NACELLE_GUARDED_BY(*mutex_) = 0;         // the oldest of the waiting messages
  std::uint64_t released_early_ NACELLE_GUARDED_BY(*mutex_) = 0;  // peeked at, and gone before release()
};

inline void ReaderQueue::append(Block& block, std::size_t waiting, const std::atomic<std::uint32_t>*& called) {
  ring_[(head_ + waiting) & mask_] = &block;
  waiting_.store(waiting + 1, std::memory_order_release);
  if (executable_ == nullptr) return;
  executor_->assume_locked();  // this queue's lock is its executor's
  if (const auto* const word = executor_->post_locked(*executable_); word != nullptr) [[unlikely]]
    called = word;
}

inline bool ReaderQueue::push_quickly(Block& block, const std::atomic<std::uint32_t>*& called) {
  const std::size_t waiting = waiting_.load(std::memory_order_relaxed);
  if (waiting >= room_) [[unlikely]]
    return false;
  append(block, waiting, called);
  return true;
}

inline Block* ReaderQueue::take_quickly() {
  const std::size_t waiting = waiting_.load(std::memory_order_relaxed);
  if (waiting == 0) return nullptr;
  Block* const block = ring_[head_ & mask_];
  // Only a message with a lifespan costs a clock read.
  if (block->expires != kNeverExpires || room_waiters_ != 0 || links_ != nullptr) [[unlikely]]
    return nullptr;
  ++head_;
  waiting_.store(waiting - 1, std::memory_order_release);
  return block;
}

}  // namespace nacelle::runtime
