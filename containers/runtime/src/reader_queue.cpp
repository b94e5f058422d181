// SPDX-License-Identifier: Apache-2.0
#include "reader_queue.hpp"

#include <algorithm>
#include <limits>
#include <mutex>

namespace nacelle::runtime {

ReaderQueue::ReaderQueue(EndpointSpec spec, Taking taking, ReadyListener* listener, const Clock& clock,
                         Watchdog* watchdog, std::uint64_t id)
    : spec_(std::move(spec)),
      taking_(taking),
      keep_all_(spec_.qos.resolved().keeps_all()),
      wants_history_(spec_.qos.resolved().durability() == Durability::TransientLocal),
      limit_(std::max<std::size_t>(1, spec_.qos.resolved().queue_capacity())),
      enabled_(spec_.gate == nullptr || spec_.gate->load(std::memory_order_acquire)),
      listener_(listener),
      status_listener_(spec_.status_listener),
      clock_(clock),
      watchdog_(watchdog),
      id_(id),
      deadline_(spec_.via == 0 ? spec_.qos.resolved().deadline() : Duration::zero()) {
  // KEEP_LAST has its room from the start. KEEP_ALL grows as it is needed, in powers of two.
  ring_.resize(keep_all_ ? std::min<std::size_t>(limit_, 16) : limit_);
}

ReaderQueue::~ReaderQueue() { close(); }

ReaderQueue::Push ReaderQueue::push(Block& block) {
  Block* evicted = nullptr;
  Push result = Push::Queued;
  {
    const std::lock_guard lock(mutex_);
    if (!enabled_ || closed_) {
      ++counters_.inactive;
      evicted = &block;
      result = Push::Inactive;
    } else {
      std::size_t waiting = waiting_.load(std::memory_order_relaxed);
      if (waiting == limit_) {
        const bool stale = ring_[head_]->expires < block.info.source_time;
        if (keep_all_ && !stale) {
          ++counters_.full;
          evicted = &block;
          result = Push::Full;
        } else {
          evicted = pop();
          --waiting;
          ++(stale ? counters_.expired : counters_.overwritten);
        }
        if (spec_.tells_lost && status_listener_ != nullptr) status_listener_->on_status();
      } else if (waiting == ring_.size()) {
        std::rotate(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(head_), ring_.end());
        head_ = 0;
        ring_.resize(std::min(limit_, ring_.size() * 2));
      }
      if (result == Push::Queued) {
        std::size_t tail = head_ + waiting;
        if (tail >= ring_.size()) tail -= ring_.size();
        ring_[tail] = &block;
        waiting_.store(waiting + 1, std::memory_order_release);
        ++counters_.received;
        if (wants_history_) note_seen(block.info);
        // Under the lock, so that close() can promise that the listener is not called afterwards.
        if (listener_ != nullptr) listener_->on_ready();
      }
      if (result == Push::Queued && deadline_.is_set()) note_arrival(block.info.source_time);
    }
  }
  if (evicted != nullptr) drop_reference(*evicted);
  return result;
}

// Under the lock. A late message is a missed deadline also when nobody has looked in between.
void ReaderQueue::note_arrival(MonotonicTime now) {
  const bool started = !deadline_.is_running();
  if (const auto missed = deadline_.message(now); missed != 0) {
    totals_.deadline_missed += missed;
    if (status_listener_ != nullptr) status_listener_->on_status();
  }
  if (started && watchdog_ != nullptr) watchdog_->poke();
}

MonotonicTime ReaderQueue::watch(MonotonicTime now) {
  if (!deadline_.is_set()) return kNeverExpires;
  const std::lock_guard lock(mutex_);
  if (const auto missed = deadline_.look(now); missed != 0) {
    totals_.deadline_missed += missed;
    if (status_listener_ != nullptr) status_listener_->on_status();
  }
  return deadline_.due();
}

// Under the lock, with something waiting.
Block* ReaderQueue::pop() {
  Block* const block = ring_[head_];
  head_ = head_ + 1 == ring_.size() ? 0 : head_ + 1;
  waiting_.store(waiting_.load(std::memory_order_relaxed) - 1, std::memory_order_release);
  if (looked_at_ != 0) [[unlikely]] {
    --looked_at_;
    ++released_early_;
  }
  if (links_ != nullptr && block->via != 0) [[unlikely]]
    links_->left(id_, block->via);
  if (room_waiters_ != 0) [[unlikely]] {
    room_word_.fetch_add(1, std::memory_order_release);
    futex_wake(room_word_, std::numeric_limits<int>::max());
  }
  return block;
}

Block* ReaderQueue::take() {
  for (;;) {
    Block* block = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.load(std::memory_order_relaxed) == 0) return nullptr;
      block = pop();
      // Only a message with a lifespan costs a look at the clock.
      if (block->expires == kNeverExpires || clock_.now() <= block->expires) {
        ++counters_.delivered;
        return block;
      }
      ++counters_.expired;
      if (spec_.tells_lost && status_listener_ != nullptr) status_listener_->on_status();
    }
    drop_reference(*block);
  }
}

void ReaderQueue::wait_for_room(MonotonicTime deadline) {
  if (!keep_all_) return;
  for (;;) {
    const std::uint32_t word = room_word_.load(std::memory_order_acquire);
    {
      const std::lock_guard lock(mutex_);
      if (!enabled_ || closed_ || waiting_.load(std::memory_order_relaxed) < limit_) return;
      ++room_waiters_;
    }
    const bool late = clock_.now() >= deadline;
    if (!late) futex_wait_until(room_word_, word, deadline);
    {
      const std::lock_guard lock(mutex_);
      --room_waiters_;
    }
    if (late) return;
  }
}

void ReaderQueue::drop_all(std::uint64_t ReaderCounters::*cause) {
  for (;;) {
    Block* block = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.load(std::memory_order_relaxed) == 0) return;
      block = pop();
      ++(counters_.*cause);
    }
    drop_reference(*block);
  }
}

void ReaderQueue::set_enabled(bool enabled) {
  {
    const std::lock_guard lock(mutex_);
    enabled_ = enabled;
    deadline_.stop();  // the next message starts it anew
  }
  if (!enabled) drop_all(&ReaderCounters::inactive);
}

void ReaderQueue::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    listener_ = nullptr;
    status_listener_ = nullptr;
  }
  drop_all(&ReaderCounters::discarded);
}

void ReaderQueue::note_rehomed() {
  const std::lock_guard lock(mutex_);
  ++counters_.rehomed;
}

void ReaderQueue::note_matched() {
  const std::lock_guard lock(mutex_);
  ++totals_.matched_total;
  if (status_listener_ != nullptr) status_listener_->on_status();
}

void ReaderQueue::note_clash(const std::string& policy, std::string text) {
  const std::lock_guard lock(mutex_);
  ++(policy == kTypePolicy ? totals_.incompatible_type : totals_.incompatible_qos);
  totals_.last_policy = policy;
  totals_.last_clash = std::move(text);
  if (status_listener_ != nullptr) status_listener_->on_status();
}

void ReaderQueue::tell() const {
  const std::lock_guard lock(mutex_);
  if (status_listener_ != nullptr) status_listener_->on_status();
}

EndpointStatus ReaderQueue::status() const {
  const std::lock_guard lock(mutex_);
  EndpointStatus status = totals_;
  status.lost = counters_.overwritten + counters_.full + counters_.expired;
  return status;
}

ReaderCounters ReaderQueue::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

bool ReaderQueue::is_enabled() const {
  const std::lock_guard lock(mutex_);
  return enabled_;
}

std::uint64_t ReaderQueue::seen(std::uint64_t writer) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, sequence] : seen_) {
    if (id == writer) return sequence;
  }
  return 0;
}

void ReaderQueue::forget_writer(std::uint64_t writer) {
  const std::lock_guard lock(mutex_);
  std::erase_if(seen_, [&](const auto& entry) { return entry.first == writer; });
}

void ReaderQueue::note_seen(const MessageInfo& info) {
  for (auto& [id, last] : seen_) {
    if (id == info.writer_id) {
      last = info.sequence;
      return;
    }
  }
  seen_.emplace_back(info.writer_id, info.sequence);
}

}  // namespace nacelle::runtime
