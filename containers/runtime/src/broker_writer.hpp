// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <vector>

#include "broker_topic.hpp"
#include "nacelle/runtime/broker.hpp"

namespace nacelle::runtime {

// A counter with one writing thread: a load and a store, no locked instruction.
class Tally {
 public:
  void add(std::uint64_t n = 1) { value_.store(value_.load(std::memory_order_relaxed) + n, std::memory_order_relaxed); }
  void set(std::uint64_t n) { value_.store(n, std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// The publishing endpoint of a topic within the process. Threads: as Writer; watch(), replay(), fold_into() and
/// note_*() from any.
class BrokerWriter final : public ProxyWriter {
 public:
  BrokerWriter(Broker& broker, std::shared_ptr<Topic> topic, EndpointSpec spec, std::uint64_t id);
  ~BrokerWriter() override;

  Block* borrow() override {
    if (!bounded_ && !lender_) [[likely]]
      return pool_->borrow_regular();
    return borrow_slowly();
  }
  Block* adopt(void* message) override { return pool_->adopt(message); }
  PublishResult publish(Block& block) override;
  /// Like publish(), with the time of the message that it repeats.
  PublishResult repeat(Block& block, MonotonicTime source_time);
  void relay(Block& block, const MessageInfo& info, MonotonicTime expires, std::span<const std::uint64_t> readers,
             std::uint64_t bytes_copied) override;
  void assert_liveliness() override;
  std::size_t reader_count() const override;
  WriterCounters counters() const override;
  EndpointStatus status() const override;
  std::uint64_t id() const override { return id_; }

  /// Marks the writer as part of its topic. From now on its destructor takes the broker's lock.
  void be_whole() { is_whole_ = true; }
  /// Gives a reader the part of the history that it has not seen. Under the topic's lock.
  void replay(ReaderQueue& reader);
  /// Counts missed deadlines, detects an expired lease, drops expired history; returns when to check again. Under the
  /// topic's lock.
  MonotonicTime watch(MonotonicTime now);
  void fold_into(Topic::Totals& totals) const;
  [[nodiscard]] std::uint64_t deadline_missed() const;
  void note_matched();
  void note_clash(const std::string& policy, std::string text);
  /// Notifies the listener that a status that is computed on demand (matched) has changed.
  void tell() const;
  [[nodiscard]] bool is_alive() const;
  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }
  /// Returns whether its messages are for this reader.
  [[nodiscard]] bool serves(const ReaderQueue& reader) const {
    return reader.is_tap() ? reader.taps(id_) : matches(spec_, reader.spec());
  }
  /// Returns whether the reader is one of its subscriptions.
  [[nodiscard]] bool is_read_by(const ReaderQueue& reader) const {
    return !reader.is_tap() && matches(spec_, reader.spec()) && (!reader.is_witness() || reader.is_counted_by(id_));
  }
  /// Returns the thread that published last; 0: none yet.
  [[nodiscard]] std::uintptr_t thread() const { return thread_.get(); }

 private:
  /// Writes sender, sequence number and times into the message, and counts it.
  void address(Block& block, MonotonicTime source_time, MonotonicTime now);
  /// Depends on the QoS only, so it needs no lock.
  [[nodiscard]] bool has_lease() const NACELLE_NOT_CHECKED { return lease_.is_set(); }
  void note_message(MonotonicTime now);
  /// Returns true if the lease has expired since the last check, and counts that. Precondition: contract_mutex_ is
  /// held.
  [[nodiscard]] bool note_lost_lease(MonotonicTime now) NACELLE_REQUIRES(contract_mutex_);
  void tell_readers() const NACELLE_REQUIRES(topic_->mutex_);
  [[nodiscard]] bool is_open() const { return spec_.gate == nullptr || spec_.gate->load(std::memory_order_acquire); }
  void refresh_routes() NACELLE_REQUIRES(topic_->mutex_);
  void reserve(const Block& block);
  [[nodiscard]] std::size_t most_in_reserve(const Block& block) const;
  void update_routes(const Block& block);
  void wait_for_room(const Block& block, MonotonicTime now);
  void keep(Block& block) NACELLE_REQUIRES(topic_->mutex_);
  Block* copy_of(const Block& block, MessagePool& pool);
  Block* borrow_slowly();
  PublishResult publish_slowly(Block& block, MonotonicTime now);
  PublishResult distribute(Block& block);
  bool hand_over(Block& block) NACELLE_NOT_CHECKED;  // it holds one lock for all neighbours that share it
  void sort_routes();
  PublishResult answer(bool refused);
  void pass_on(ReaderQueue& reader, Block& block);

  struct Route {
    ReaderQueue* queue;
    FutexMutex* mutex;
  };

  Broker& broker_;
  const Clock& clock_;
  const std::shared_ptr<Topic> topic_;
  const std::atomic<std::uint64_t>& topic_version_;
  const EndpointSpec spec_;
  const std::uint64_t id_;
  const bool keeps_history_;
  const std::size_t history_limit_;
  const Duration lifespan_;
  const Duration longest_wait_;  // for room in KEEP_ALL readers; zero: never
  const bool bounded_;           // the pool has a limit: QoS::when_dry()
  bool was_dry_ = false;
  std::shared_ptr<BufferLender> lender_;  // that of the only reader
  std::unique_ptr<MessagePool> pool_;
  std::vector<std::shared_ptr<ReaderQueue>> routes_;
  ReaderQueue* sole_ = nullptr;  // the only route, if the message only needs to be passed on; not for the first message
  std::vector<Route> originals_;      // routes that get the message itself
  std::vector<ReaderQueue*> copied_;  // routes that get a copy
  std::size_t owners_ = 0;
  std::size_t deepest_ = 0;
  std::uint64_t routes_version_ = 0;
  std::deque<Block*> history_ NACELLE_GUARDED_BY(topic_->mutex_);
  // Copies of the history for owners that join late.
  std::unique_ptr<MessagePool> replay_pool_ NACELLE_GUARDED_BY(topic_->mutex_);
  Tally published_, inactive_, would_block_, copies_, bytes_copied_, pool_dry_, first_ns_, last_ns_, thread_;

  mutable FutexMutex contract_mutex_;
  DeadlineWatch deadline_ NACELLE_GUARDED_BY(contract_mutex_);
  LeaseWatch lease_ NACELLE_GUARDED_BY(contract_mutex_);
  EndpointStatus totals_ NACELLE_GUARDED_BY(contract_mutex_);
  std::vector<ReaderQueue*> chosen_;  // of relay(), kept to reuse the memory
  std::uint64_t last_relayed_ = 0;
  const bool has_contract_;  // a deadline or a lease: without one publish() does not take the lock
  const bool is_plain_;      // no contract, history, lifespan or the like: only readers
  bool is_whole_ = false;
};

}  // namespace nacelle::runtime
