// SPDX-License-Identifier: Apache-2.0
#include "broker_reader.hpp"

#include <algorithm>
#include <mutex>

namespace nacelle::runtime {

ReaderQueue::ReaderQueue(EndpointSpec spec, Taking taking, ReadyListener* listener)
    : spec_(std::move(spec)),
      taking_(taking),
      keep_all_(spec_.qos.resolved().keeps_all()),
      wants_history_(spec_.qos.resolved().durability() == Durability::TransientLocal),
      limit_(std::max<std::size_t>(1, spec_.qos.resolved().queue_capacity())),
      enabled_(spec_.gate == nullptr || spec_.gate->load(std::memory_order_acquire)),
      listener_(listener) {
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
        if (keep_all_) {
          ++counters_.full;
          evicted = &block;
          result = Push::Full;
        } else {
          evicted = ring_[head_];
          head_ = head_ + 1 == ring_.size() ? 0 : head_ + 1;
          --waiting;
          ++counters_.overwritten;
        }
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
    }
  }
  if (evicted != nullptr) drop_reference(*evicted);
  return result;
}

Block* ReaderQueue::take() {
  const std::lock_guard lock(mutex_);
  const std::size_t waiting = waiting_.load(std::memory_order_relaxed);
  if (waiting == 0) return nullptr;
  Block* const block = ring_[head_];
  head_ = head_ + 1 == ring_.size() ? 0 : head_ + 1;
  waiting_.store(waiting - 1, std::memory_order_release);
  ++counters_.delivered;
  return block;
}

void ReaderQueue::drop_all(std::uint64_t ReaderCounters::*cause) {
  for (;;) {
    Block* block = nullptr;
    {
      const std::lock_guard lock(mutex_);
      const std::size_t waiting = waiting_.load(std::memory_order_relaxed);
      if (waiting == 0) return;
      block = ring_[head_];
      head_ = head_ + 1 == ring_.size() ? 0 : head_ + 1;
      waiting_.store(waiting - 1, std::memory_order_release);
      ++(counters_.*cause);
    }
    drop_reference(*block);
  }
}

void ReaderQueue::set_enabled(bool enabled) {
  {
    const std::lock_guard lock(mutex_);
    enabled_ = enabled;
  }
  if (!enabled) drop_all(&ReaderCounters::inactive);
}

void ReaderQueue::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    listener_ = nullptr;
  }
  drop_all(&ReaderCounters::discarded);
}

void ReaderQueue::note_rehomed() {
  const std::lock_guard lock(mutex_);
  ++counters_.rehomed;
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
