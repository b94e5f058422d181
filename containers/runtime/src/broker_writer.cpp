// SPDX-License-Identifier: Apache-2.0
#include "broker_writer.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "nacelle/base/expect.hpp"
#include "nacelle/runtime/repeat.hpp"
#include "qos_clash.hpp"
#include "this_thread.hpp"

namespace nacelle::runtime {
namespace {

// Small messages for the whole depth of the queues are allocated at once. A queue of large messages allocates when it
// first fills: most queues never do, and the pages of their messages would be the greater part of a robot's memory. The
// messages that circulate even with empty queues (one being filled, one waiting, one in a callback) are allocated with
// the first message.
constexpr std::size_t kReserveBytes = std::size_t{512} * 1024, kReserveMessages = 3;

Duration lease_of(const QoS& qos) {
  // With automatic liveliness, a writer is alive as long as the process is.
  return qos.liveliness() == Liveliness::ManualByTopic ? qos.liveliness_lease_duration() : Duration::zero();
}

}  // namespace

BrokerWriter::BrokerWriter(Broker& broker, std::shared_ptr<Topic> topic, EndpointSpec spec, std::uint64_t id)
    : broker_(broker),
      clock_(broker.clock_),
      topic_(std::move(topic)),
      topic_version_(topic_->version_),
      spec_(std::move(spec)),
      id_(id),
      keeps_history_(spec_.via == 0 && spec_.qos.resolved().durability() == Durability::TransientLocal),
      history_limit_(std::max<std::size_t>(1, spec_.qos.resolved().queue_capacity())),
      lifespan_(spec_.qos.resolved().lifespan()),
      longest_wait_(spec_.qos.reliability() == Reliability::BestEffort ? Duration::zero()
                                                                       : spec_.qos.max_blocking_time()),
      bounded_(spec_.qos.when_dry() != PoolPolicy::Grow),
      pool_(std::make_unique<MessagePool>(*spec_.type)),
      deadline_(spec_.via == 0 ? spec_.qos.resolved().deadline() : Duration::zero()),
      lease_(lease_of(spec_.qos.resolved()), broker_.clock_.now()),
      has_contract_(deadline_.is_set() || lease_.is_set()),
      is_plain_(!has_contract_ && !keeps_history_ && lifespan_ == Duration::zero() &&
                longest_wait_ == Duration::zero()) {
  const LockGuard lock(topic_->mutex_);
  topic_->writers_.push_back(this);
  if (!is_tool(spec_)) {
    for (const auto& reader : topic_->readers_) introduce(*this, *reader);
  }
  // A writer that joins a running graph allocates its messages now, not during its first publish().
  refresh_routes();
  Block* const blank = pool_->borrow();
  reserve(*blank);
  drop_reference(*blank);
  if (lease_.is_set()) broker_.look_earlier();
}

BrokerWriter::~BrokerWriter() {
  {
    const LockGuard lock(topic_->mutex_);
    topic_->gone_.handed_over = handed_over(*topic_);
    std::erase(topic_->writers_, this);
    for (const auto& reader : topic_->readers_) reader->forget_writer(id_);
    tell_readers();
    fold_into(topic_->gone_);
    broker_.links_.gone(id_);
  }
  for (Block* block : history_) drop_reference(*block);
  broker_.retire(spec_, std::move(pool_));
  if (replay_pool_) broker_.retire(spec_, std::move(replay_pool_));
  if (is_whole_) broker_.note_end(*topic_);
}

// For a pool with a limit, or for a reader in another process.
Block* BrokerWriter::borrow_slowly() {
  Block* const block = pool_->borrow();
  if (lender_ && block != nullptr) lender_->prepare(id_, *block);
  if (!bounded_) return block;
  const bool dry = block == nullptr || pool_->is_spare(*block);
  // The fault is reported once when the pool runs dry, not for each message.
  if (dry && !was_dry_ && spec_.qos.when_dry() == PoolPolicy::Fail && spec_.on_fault)
    spec_.on_fault("POOL_DRY",
                   fmt::format("{}: its readers keep all {} messages that their depths allow; let them keep fewer, "
                               "give them a greater depth, or set when_dry: grow",
                               spec_.topic, pool_->limit()));
  was_dry_ = dry;
  if (block == nullptr) pool_dry_.add();
  return block;
}

inline void BrokerWriter::address(Block& block, MonotonicTime source_time, MonotonicTime now) {
  const std::uint64_t sequence = published_.get() + 1;
  block.info = {id_, sequence, source_time, now};
  block.expires = kNeverExpires;
  last_ns_.set(static_cast<std::uint64_t>(now.nanoseconds()));
  published_.set(sequence);
  thread_.set(this_thread_mark());
}

PublishResult BrokerWriter::publish(Block& block) {
  if (!is_open()) [[unlikely]] {
    inactive_.add();
    drop_reference(block);
    return PublishResult::Inactive;
  }
  if (bounded_ && pool_->is_spare(block)) [[unlikely]] {
    pool_dry_.add();
    drop_reference(block);
    return PublishResult::PoolDry;
  }
  const MonotonicTime now = clock_.now();
  address(block, now, now);
  if (sole_ == nullptr || topic_version_.load(std::memory_order_acquire) != routes_version_)
    return publish_slowly(block, now);
  // One reader and no further work, as in most streams: the caller's reference becomes the reader's.
  const std::atomic<std::uint32_t>* called = nullptr;
  FutexMutex& mutex = sole_->mutex();
  mutex.lock();
  sole_->assume_locked();
  const bool done = sole_->push_quickly(block, called);
  mutex.unlock();
  if (called != nullptr) futex_wake(*called, 1);
  return done ? PublishResult::Published : answer(sole_->push(block) == ReaderQueue::Push::Full);
}

PublishResult repeat(Writer& writer, Block& block, MonotonicTime source_time) {
  auto* const of_broker = dynamic_cast<BrokerWriter*>(&writer);
  NACELLE_EXPECT(of_broker != nullptr, "only a container's own writer can repeat a message");
  return of_broker->repeat(block, source_time);
}

PublishResult BrokerWriter::repeat(Block& block, MonotonicTime source_time) {
  if (!is_open() || (bounded_ && pool_->is_spare(block))) return publish(block);  // which drops and counts it
  const MonotonicTime now = clock_.now();
  address(block, source_time, now);
  return publish_slowly(block, now);
}

// The general case: several readers, a contract, a history or copies, or a changed set of readers.
PublishResult BrokerWriter::publish_slowly(Block& block, MonotonicTime now) {
  if (is_plain_ && block.info.sequence != 1 && topic_version_.load(std::memory_order_acquire) == routes_version_)
    return distribute(block);
  if (lifespan_ != Duration::zero()) block.expires = now + lifespan_;
  if (block.info.sequence == 1) {
    first_ns_.set(static_cast<std::uint64_t>(now.nanoseconds()));
    pool_->warm(block.message, most_in_reserve(block));
    sort_routes();
  }
  if (has_contract_) note_message(now);
  if (longest_wait_ != Duration::zero()) wait_for_room(block, now);
  if (!keeps_history_) {
    update_routes(block);
    return distribute(block);
  }
  // A late joiner gets its history under the same lock, so that it receives each message once and in order.
  const LockGuard lock(topic_->mutex_);
  if (topic_->version_.load(std::memory_order_relaxed) != routes_version_) {
    refresh_routes();
    reserve(block);
  }
  keep(block);
  return distribute(block);
}

void BrokerWriter::update_routes(const Block& block) {
  if (topic_->version_.load(std::memory_order_acquire) == routes_version_) return;
  const LockGuard lock(topic_->mutex_);
  refresh_routes();
  reserve(block);
}

// Before any reader gets the message, and without a lock: other writers may fill the room again; then the refusal is
// counted.
void BrokerWriter::wait_for_room(const Block& block, MonotonicTime now) {
  if (this_thread_runs_callbacks) return;
  update_routes(block);
  for (const auto& reader : routes_) reader->wait_for_room(now + longest_wait_);
}

// Under the topic's lock.
void BrokerWriter::keep(Block& block) {
  add_reference(block);
  history_.push_back(&block);
  if (history_.size() <= history_limit_) return;
  drop_reference(*history_.front());
  history_.pop_front();
}

// --- the contract -------------------------------------------------------------------------------------------------------

bool BrokerWriter::note_lost_lease(MonotonicTime now) {
  const bool died = lease_.look(now);
  if (died) ++totals_.liveliness_lost;
  return died;
}

void BrokerWriter::note_message(MonotonicTime now) {
  bool missed = false, started = false, revived = false, died = false;
  {
    const LockGuard lock(contract_mutex_);
    if (deadline_.is_set()) {
      started = !deadline_.is_running();
      const auto late = deadline_.message(now);
      totals_.deadline_missed += late;
      missed = late != 0;
    }
    died = note_lost_lease(now);
    revived = lease_.is_set() && lease_.show_life(now);
  }
  if (missed || died) tell();
  if (has_lease()) broker_.links_.life(id_);
  if (revived) {
    const LockGuard lock(topic_->mutex_);
    tell_readers();
  }
  if (started || revived) broker_.look_earlier();
}

void BrokerWriter::assert_liveliness() {
  if (has_lease()) broker_.links_.life(id_);
  bool died = false;
  {
    const LockGuard lock(contract_mutex_);
    if (!lease_.is_set()) return;
    const MonotonicTime now = broker_.clock_.now();
    died = note_lost_lease(now);
    if (!lease_.show_life(now)) return;
  }
  if (died) tell();
  {
    const LockGuard lock(topic_->mutex_);
    tell_readers();
  }
  broker_.look_earlier();
}

MonotonicTime BrokerWriter::watch(MonotonicTime now) {
  topic_->assume_locked();
  while (!history_.empty() && history_.front()->expires < now) {
    drop_reference(*history_.front());
    history_.pop_front();
  }
  if (!has_contract_) return kNeverExpires;
  bool missed = false, died = false;
  MonotonicTime due;
  {
    const LockGuard lock(contract_mutex_);
    if (!is_open()) deadline_.stop();
    if (deadline_.is_set()) {
      const auto late = deadline_.look(now);
      totals_.deadline_missed += late;
      missed = late != 0;
    }
    died = note_lost_lease(now);
    due = std::min(deadline_.due(), lease_.due());
  }
  if (missed || died) tell();
  if (died) tell_readers();
  return due;
}

bool BrokerWriter::is_alive() const {
  const LockGuard lock(contract_mutex_);
  return lease_.is_alive();
}

void BrokerWriter::note_matched() {
  {
    const LockGuard lock(contract_mutex_);
    ++totals_.matched_total;
  }
  tell();
}

void BrokerWriter::note_clash(const std::string& policy, std::string text) {
  {
    const LockGuard lock(contract_mutex_);
    ++(policy == kTypePolicy ? totals_.incompatible_type : totals_.incompatible_qos);
    totals_.last_policy = policy;
    totals_.last_clash = std::move(text);
  }
  tell();
}

void BrokerWriter::tell() const {
  if (spec_.status_listener != nullptr) spec_.status_listener->on_status();
}

// Under the topic's lock.
void BrokerWriter::tell_readers() const {
  for (const auto& reader : topic_->readers_) {
    if (is_read_by(*reader)) reader->tell();
  }
}

// --- what others read ---------------------------------------------------------------------------------------------------

std::size_t BrokerWriter::reader_count() const {
  const LockGuard lock(topic_->mutex_);
  return static_cast<std::size_t>(
      std::ranges::count_if(topic_->readers_, [&](const auto& reader) { return is_read_by(*reader); }));
}

WriterCounters BrokerWriter::counters() const {
  return {published_.get(),    inactive_.get(), would_block_.get(), copies_.get(),
          bytes_copied_.get(), pool_->made(),   pool_dry_.get()};
}

EndpointStatus BrokerWriter::status() const {
  const auto matched = static_cast<std::uint32_t>(reader_count());
  const LockGuard lock(contract_mutex_);
  EndpointStatus status = totals_;
  status.matched = matched;
  return status;
}

std::uint64_t BrokerWriter::deadline_missed() const {
  const LockGuard lock(contract_mutex_);
  return totals_.deadline_missed;
}

void BrokerWriter::fold_into(Topic::Totals& totals) const {
  const WriterCounters mine = counters();
  totals.written.published += mine.published;
  totals.written.inactive += mine.inactive;
  totals.written.would_block += mine.would_block;
  totals.written.copies += mine.copies;
  totals.written.bytes_copied += mine.bytes_copied;
  totals.written.pool_grown += mine.pool_grown;
  totals.written.pool_dry += mine.pool_dry;
  if (mine.published == 0) return;
  totals.first_ns = totals.first_ns == 0 ? first_ns_.get() : std::min(totals.first_ns, first_ns_.get());
  totals.last_ns = std::max(totals.last_ns, last_ns_.get());
}

// --- hand-over ----------------------------------------------------------------------------------------------------------

void BrokerWriter::replay(ReaderQueue& reader) {
  topic_->assume_locked();
  if (!keeps_history_ || !serves(reader)) return;
  const MonotonicTime now = broker_.clock_.now();
  for (Block* block : history_) {
    if (block->info.sequence <= reader.seen(id_) || block->expires < now) continue;
    if (reader.taking() == Taking::Share) {
      add_reference(*block);
      reader.push(*block);
      continue;
    }
    // The writer's own pool belongs to its thread; a reader joins on another thread.
    if (!replay_pool_) replay_pool_ = std::make_unique<MessagePool>(*spec_.type);
    reader.push(*copy_of(*block, *replay_pool_));  // this pool has no limit
  }
}

// Under the topic's lock.
void BrokerWriter::refresh_routes() {
  routes_.clear();
  std::size_t deepest = keeps_history_ ? history_limit_ : 0;
  for (const auto& reader : topic_->readers_) {
    if (reader->is_witness() || !serves(*reader)) continue;
    routes_.push_back(reader);
    deepest = std::max(deepest, reader->spec().qos.resolved().queue_capacity());
  }
  deepest_ = deepest;
  // If there is also a local reader, or a history, lent memory would be read here while it is reused there.
  lender_ = spec_.type->holds_buffers && !keeps_history_ && routes_.size() == 1 ? routes_.front()->lender() : nullptr;
  sort_routes();
  routes_version_ = topic_->version_.load(std::memory_order_relaxed);
}

// Decides which readers get the original and which a copy, when a reader comes or goes, not for each message.
void BrokerWriter::sort_routes() {
  originals_.clear();
  copied_.clear();
  sole_ = is_plain_ && published_.get() != 0 && routes_.size() == 1 ? routes_.front().get() : nullptr;
  for (const auto& reader : routes_) {
    if (reader->taking() == Taking::Share) {
      originals_.push_back({reader.get(), &reader->mutex()});
    } else {
      copied_.push_back(reader.get());
    }
  }
  owners_ = copied_.size();
  // With owners only, the last of them in subscription order needs no copy.
  if (!originals_.empty() || keeps_history_ || copied_.empty()) return;
  originals_.push_back({copied_.back(), &copied_.back()->mutex()});
  copied_.pop_back();
}

// The queues of all sharers hold the same last messages, and those of each further owner hold copies of them. In
// addition, each reader has one message in its callback and may keep one, and the writer fills one.
void BrokerWriter::reserve(const Block& block) {
  const std::size_t copies = owners_ > 1 ? owners_ - 1 : 0;
  const std::size_t wanted = deepest_ * (1 + copies) + 2 * routes_.size() + 1;
  if (bounded_) pool_->set_limit(wanted);
  if (routes_.empty()) return;
  pool_->reserve(std::min(wanted, most_in_reserve(block)), block.message);
}

// Returns how many messages like this one are allocated before they are needed.
std::size_t BrokerWriter::most_in_reserve(const Block& block) const {
  if (!spec_.reserves) return kReserveMessages;
  return std::max(kReserveMessages, kReserveBytes / (spec_.type->size + spec_.type->encoded_size(block.message)));
}

// Returns null if the pool is dry.
Block* BrokerWriter::copy_of(const Block& block, MessagePool& pool) {
  Block* const copy = pool.borrow_regular();
  if (copy == nullptr) return nullptr;
  spec_.type->copy_assign(copy->message, block.message);
  copy->info = block.info;
  copy->expires = block.expires;
  copies_.add();
  bytes_copied_.add(spec_.type->encoded_size(block.message));
  return copy;
}

// Passes the message to the readers that get the original. Adjacent readers that share a lock, such as those of one
// executor, are served under one hold of it.
bool BrokerWriter::hand_over(Block& block) {
  // Takes all references in one step. The caller's reference becomes the last reader's: it keeps the message alive
  // until that push.
  const auto count = static_cast<std::uint32_t>(originals_.size());
  if (block.references.load(std::memory_order_relaxed) == 1) [[likely]] {
    block.references.store(count, std::memory_order_relaxed);
  } else {
    block.references.fetch_add(count - 1, std::memory_order_relaxed);
  }
  bool refused = false;
  FutexMutex* held = nullptr;
  const std::atomic<std::uint32_t>* called = nullptr;
  const auto release = [&]() NACELLE_NOT_CHECKED {
    if (held == nullptr) return;
    std::exchange(held, nullptr)->unlock();
    // The woken thread may take over this CPU at once, and must not block on a lock that this thread holds.
    if (called != nullptr) [[unlikely]]
      futex_wake(*std::exchange(called, nullptr), 1);
  };
  for (const Route& route : originals_) {
    if (route.mutex != held) {
      release();
      route.mutex->lock();
      held = route.mutex;
    }
    if (!route.queue->push_quickly(block, called)) [[unlikely]] {
      release();
      refused |= route.queue->push(block) == ReaderQueue::Push::Full;
    }
  }
  release();
  return refused;
}

// If there is a non-owning reader or a history, every owner gets a copy; with owners only, the last one gets the
// original.
PublishResult BrokerWriter::distribute(Block& block) {
  bool refused = false;
  for (ReaderQueue* const owner : copied_) {
    if (Block* const copy = copy_of(block, *pool_)) {
      refused |= owner->push(*copy) == ReaderQueue::Push::Full;
    } else {
      pool_dry_.add();
    }
  }
  if (originals_.empty()) {
    drop_reference(block);
  } else {
    refused |= hand_over(block);
  }
  return answer(refused);
}

PublishResult BrokerWriter::answer(bool refused) {
  if (!refused || spec_.qos.reliability() == Reliability::BestEffort) return PublishResult::Published;
  would_block_.add();
  return PublishResult::WouldBlock;
}

}  // namespace nacelle::runtime
