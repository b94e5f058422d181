// SPDX-License-Identifier: Apache-2.0
#include "reader_queue.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "nacelle/base/mutex.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::runtime {
namespace {

// KEEP_LAST allocates its ring at the start, up to a limit. KEEP_ALL grows on demand.
std::size_t first_size(std::size_t depth, bool keeps_all) {
  constexpr std::size_t kLargest = std::size_t{1} << 16, kOfKeepAll = 16;
  return std::bit_ceil(std::clamp<std::size_t>(depth, 1, keeps_all ? kOfKeepAll : kLargest));
}

}  // namespace

ReaderQueue::ReaderQueue(EndpointSpec spec, Taking taking, ReadyListener* listener, const Clock& clock,
                         QosWatch* qos_watch, std::uint64_t id)
    : ReaderQueue(std::move(spec), taking, listener, nullptr, clock, qos_watch, id) {}

ReaderQueue::ReaderQueue(EndpointSpec spec, Taking taking, Executable& executable, const Clock& clock,
                         QosWatch* qos_watch, std::uint64_t id)
    : ReaderQueue(std::move(spec), taking, nullptr, &executable, clock, qos_watch, id) {
  executable.take_from(*this);
}

ReaderQueue::ReaderQueue(EndpointSpec&& spec, Taking taking, ReadyListener* listener, Executable* executable,
                         const Clock& clock, QosWatch* qos_watch, std::uint64_t id)
    : spec_(std::move(spec)),
      taking_(taking),
      keep_all_(spec_.qos.resolved().keeps_all()),
      wants_history_(spec_.qos.resolved().durability() == Durability::TransientLocal),
      mutex_(executable != nullptr ? executable->group().executor().mutex() : std::make_shared<FutexMutex>()),
      executor_(executable != nullptr ? &executable->group().executor() : nullptr),
      executable_(executable),
      mask_(first_size(spec_.qos.resolved().queue_capacity(), keep_all_) - 1),
      ring_(std::make_unique<Block*[]>(size())),
      limit_(std::max<std::size_t>(1, spec_.qos.resolved().queue_capacity())),
      enabled_(spec_.gate == nullptr || spec_.gate->load(std::memory_order_acquire)),
      listener_(listener),
      status_listener_(spec_.status_listener),
      clock_(clock),
      qos_watch_(qos_watch),
      id_(id),
      deadline_(spec_.via == 0 ? spec_.qos.resolved().deadline() : Duration::zero()) {
  note_room();
}

ReaderQueue::~ReaderQueue() { close(); }

// Under the lock, as everything down to pop_unread().
void ReaderQueue::note_room() {
  const bool quick = enabled_ && !closed_ && executable_ != nullptr && !wants_history_ && !deadline_.is_set();
  room_ = quick ? std::min(limit_, size()) : 0;
}

ReaderQueue::Push ReaderQueue::push_locked(Block& block, Loose& loose, const std::atomic<std::uint32_t>*& called) {
  if (!enabled_ || closed_) {
    ++counters_.inactive;
    loose.evicted = &block;
    return Push::Inactive;
  }
  std::size_t waiting = waiting_.load(std::memory_order_relaxed);
  if (waiting == limit_) {
    loose.tell = spec_.tells_lost;
    const bool stale = ring_[head_ & mask_]->expires < block.info.source_time;
    if (keep_all_ && !stale) {
      ++counters_.full;
      loose.evicted = &block;
      return Push::Full;
    }
    loose.evicted = pop_unread();
    --waiting;
    ++(stale ? counters_.expired : counters_.overwritten);
  } else if (waiting == size()) {
    grow();
  }
  append(block, waiting, called);
  if (wants_history_) note_seen(block.info);
  if (deadline_.is_set()) note_arrival(block.info.source_time, loose);
  return Push::Queued;
}

void ReaderQueue::grow() {
  const std::size_t mask = 2 * size() - 1;
  auto larger = std::make_unique<Block*[]>(mask + 1);
  for (std::size_t i = 0; i < size(); ++i) larger[(head_ + i) & mask] = ring_[(head_ + i) & mask_];
  ring_ = std::move(larger);
  mask_ = mask;
  note_room();
}

// A late message is a missed deadline even if there was no check in between.
void ReaderQueue::note_arrival(MonotonicTime now, Loose& loose) {
  loose.poke = !deadline_.is_running();
  if (const auto missed = deadline_.message(now); missed != 0) {
    totals_.deadline_missed += missed;
    loose.tell = true;
  }
}

// Precondition: a message is waiting.
Block* ReaderQueue::pop() {
  Block* const block = ring_[head_++ & mask_];
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

Block* ReaderQueue::pop_unread() {
  ++unread_;
  return pop();
}

// Releasing a message may run foreign code, and a listener may take locks: neither happens under this queue's lock.
ReaderQueue::Push ReaderQueue::push(Block& block) {
  Loose loose;
  const std::atomic<std::uint32_t>* called = nullptr;
  Push result{};
  {
    const LockGuard lock(*mutex_);
    result = push_locked(block, loose, called);
  }
  // The woken thread may take over this CPU at once, and must not block on a lock that this thread holds.
  if (called != nullptr) futex_wake(*called, 1);
  if (loose.evicted != nullptr) drop_reference(*loose.evicted);
  if (loose.tell) tell();
  if (loose.poke && qos_watch_ != nullptr) qos_watch_->poke();
  if (executor_ == nullptr && result == Push::Queued) {
    const LockGuard lock(listener_mutex_);
    if (listener_ != nullptr) listener_->on_ready();
  }
  return result;
}

MonotonicTime ReaderQueue::watch(MonotonicTime now) {
  if (!has_deadline()) return kNeverExpires;
  MonotonicTime due;
  bool missed = false;
  {
    const LockGuard lock(*mutex_);
    const auto count = deadline_.look(now);
    totals_.deadline_missed += count;
    missed = count != 0;
    due = deadline_.due();
  }
  if (missed) tell();
  return due;
}

Block* ReaderQueue::take() {
  for (;;) {
    Block* block = nullptr;
    {
      const LockGuard lock(*mutex_);
      if (waiting_.load(std::memory_order_relaxed) == 0) return nullptr;
      block = pop();
      if (block->expires == kNeverExpires || clock_.now() <= block->expires) return block;
      ++unread_;
      ++counters_.expired;
    }
    if (spec_.tells_lost) tell();
    drop_reference(*block);
  }
}

void ReaderQueue::wait_for_room(MonotonicTime deadline) {
  if (!keep_all_) return;
  for (;;) {
    const std::uint32_t word = room_word_.load(std::memory_order_acquire);
    {
      const LockGuard lock(*mutex_);
      if (!enabled_ || closed_ || waiting_.load(std::memory_order_relaxed) < limit_) return;
      ++room_waiters_;
    }
    const bool late = clock_.now() >= deadline;
    if (!late) futex_wait_until(room_word_, word, deadline);
    {
      const LockGuard lock(*mutex_);
      --room_waiters_;
    }
    if (late) return;
  }
}

void ReaderQueue::drop_all(std::uint64_t ReaderCounters::*cause) {
  for (;;) {
    Block* block = nullptr;
    {
      const LockGuard lock(*mutex_);
      if (waiting_.load(std::memory_order_relaxed) == 0) return;
      block = pop_unread();
      ++(counters_.*cause);
    }
    drop_reference(*block);
  }
}

void ReaderQueue::set_enabled(bool enabled) {
  {
    const LockGuard lock(*mutex_);
    enabled_ = enabled;
    note_room();
    deadline_.stop();  // the next message restarts it
  }
  if (!enabled) drop_all(&ReaderCounters::inactive);
}

void ReaderQueue::close() {
  {
    const LockGuard lock(*mutex_);
    closed_ = true;
    executable_ = nullptr;
    note_room();
  }
  {
    const LockGuard lock(listener_mutex_);
    listener_ = nullptr;
  }
  {
    const LockGuard lock(status_mutex_);
    status_listener_ = nullptr;
  }
  drop_all(&ReaderCounters::discarded);
}

void ReaderQueue::note_rehomed() {
  const LockGuard lock(*mutex_);
  ++counters_.rehomed;
}

void ReaderQueue::note_matched() {
  {
    const LockGuard lock(*mutex_);
    ++totals_.matched_total;
  }
  tell();
}

void ReaderQueue::note_clash(const std::string& policy, std::string text) {
  {
    const LockGuard lock(*mutex_);
    ++(policy == kTypePolicy ? totals_.incompatible_type : totals_.incompatible_qos);
    totals_.last_policy = policy;
    totals_.last_clash = std::move(text);
  }
  tell();
}

void ReaderQueue::tell() const {
  const LockGuard lock(status_mutex_);
  if (status_listener_ != nullptr) status_listener_->on_status();
}

EndpointStatus ReaderQueue::status() const {
  const LockGuard lock(*mutex_);
  EndpointStatus status = totals_;
  status.lost = counters_.overwritten + counters_.full + counters_.expired;
  return status;
}

ReaderCounters ReaderQueue::counters() const {
  const LockGuard lock(*mutex_);
  ReaderCounters all = counters_;
  all.received += head_ + waiting_.load(std::memory_order_relaxed);
  all.delivered = head_ - unread_;
  return all;
}

void ReaderQueue::report(ReaderReport& row) const {
  row.topic = spec_.topic;
  row.type = spec_.type->name;
  row.node = spec_.node;
  row.other_process = spec_.via != 0;
  row.keeps_all = keep_all_;
  row.depth = limit_;
  const ReaderCounters all = counters();
  row.delivered = all.delivered;
  row.overwritten = all.overwritten;
  row.full = all.full;
  row.inactive = all.inactive;
  row.expired = all.expired;
  row.discarded = all.discarded;
  row.latency_p50 = latency_.quantile(0.5);
  row.latency_p99 = latency_.quantile(0.99);
  row.latency_max = latency_.max();
  const LockGuard lock(*mutex_);
  row.open = enabled_;
  row.waiting = waiting_.load(std::memory_order_relaxed);
  row.deadline_missed = totals_.deadline_missed;
}

bool ReaderQueue::is_enabled() const {
  const LockGuard lock(*mutex_);
  return enabled_;
}

std::uint64_t ReaderQueue::seen(std::uint64_t writer) const {
  const LockGuard lock(*mutex_);
  for (const auto& [id, sequence] : seen_) {
    if (id == writer) return sequence;
  }
  return 0;
}

void ReaderQueue::forget_writer(std::uint64_t writer) {
  const LockGuard lock(*mutex_);
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
