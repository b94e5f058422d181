// SPDX-License-Identifier: Apache-2.0
#include "broker_writer.hpp"

#include <algorithm>

#include "clash.hpp"
#include "this_thread.hpp"

namespace nacelle::runtime {
namespace {

// What a deep queue may need is made at once while it is small; beyond that, a burst of large messages pays when it comes.
constexpr std::size_t kReserveMessages = 16, kReserveBytes = std::size_t{512} * 1024;

Duration lease_of(const QoS& qos) {
  // Automatic liveliness is the process's own: while it lives, its writers do.
  return qos.liveliness() == Liveliness::ManualByTopic ? qos.liveliness_lease_duration() : Duration::zero();
}

}  // namespace

BrokerWriter::BrokerWriter(Broker& broker, std::shared_ptr<Topic> topic, EndpointSpec spec, std::uint64_t id)
    : broker_(broker),
      topic_(std::move(topic)),
      spec_(std::move(spec)),
      id_(id),
      keeps_history_(spec_.via == 0 && spec_.qos.resolved().durability() == Durability::TransientLocal),
      history_limit_(std::max<std::size_t>(1, spec_.qos.resolved().queue_capacity())),
      lifespan_(spec_.qos.resolved().lifespan()),
      longest_wait_(spec_.qos.reliability() == Reliability::BestEffort ? Duration::zero()
                                                                       : spec_.qos.max_blocking_time()),
      pool_(std::make_unique<MessagePool>(*spec_.type)),
      deadline_(spec_.via == 0 ? spec_.qos.resolved().deadline() : Duration::zero()),
      lease_(lease_of(spec_.qos.resolved()), broker_.clock_.now()),
      has_contract_(deadline_.is_set() || lease_.is_set()) {
  const std::lock_guard lock(topic_->mutex_);
  topic_->writers_.push_back(this);
  if (!is_tool(spec_)) {
    for (const auto& reader : topic_->readers_) introduce(*this, *reader);
  }
  // A writer that joins a running graph makes its messages now, not in the middle of its first publish().
  refresh_routes();
  Block* const blank = pool_->borrow();
  reserve(*blank);
  drop_reference(*blank);
  if (lease_.is_set()) broker_.look_earlier();
}

BrokerWriter::~BrokerWriter() {
  {
    const std::lock_guard lock(topic_->mutex_);
    std::erase(topic_->writers_, this);
    for (const auto& reader : topic_->readers_) reader->forget_writer(id_);
    tell_readers();
    fold_into(topic_->gone_);
    broker_.links_.gone(id_);
  }
  for (Block* block : history_) drop_reference(*block);
  broker_.retire(spec_, std::move(pool_));
  if (replay_pool_) broker_.retire(spec_, std::move(replay_pool_));
}

PublishResult BrokerWriter::publish(Block& block) {
  if (!is_open()) {
    inactive_.add();
    drop_reference(block);
    return PublishResult::Inactive;
  }
  const MonotonicTime now = broker_.clock_.now();
  const std::uint64_t sequence = published_.get() + 1;
  block.info = {id_, sequence, now, now};
  block.expires = lifespan_ == Duration::zero() ? kNeverExpires : now + lifespan_;
  if (sequence == 1) {
    first_ns_.set(static_cast<std::uint64_t>(now.nanoseconds()));
    pool_->warm(block.message);
  }
  last_ns_.set(static_cast<std::uint64_t>(now.nanoseconds()));
  published_.set(sequence);
  if (has_contract_) note_message(now);
  if (longest_wait_ != Duration::zero()) wait_for_room(block, now);
  if (!keeps_history_) {
    update_routes(block);
    return distribute(block);
  }
  // A late joiner is served under the same lock, so that it gets each message once and in order.
  const std::lock_guard lock(topic_->mutex_);
  if (topic_->version_.load(std::memory_order_relaxed) != routes_version_) {
    refresh_routes();
    reserve(block);
  }
  keep(block);
  return distribute(block);
}

void BrokerWriter::update_routes(const Block& block) {
  if (topic_->version_.load(std::memory_order_acquire) == routes_version_) return;
  const std::lock_guard lock(topic_->mutex_);
  refresh_routes();
  reserve(block);
}

// Before anything is handed over, and without a lock: others may fill the room again, then the refusal is counted.
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

void BrokerWriter::note_message(MonotonicTime now) {
  bool missed = false, started = false, revived = false;
  {
    const std::lock_guard lock(contract_mutex_);
    if (deadline_.is_set()) {
      started = !deadline_.is_running();
      const auto late = deadline_.message(now);
      totals_.deadline_missed += late;
      missed = late != 0;
    }
    revived = lease_.is_set() && lease_.show_life(now);
  }
  if (missed) tell();
  if (lease_.is_set()) broker_.links_.life(id_);
  if (revived) {
    const std::lock_guard lock(topic_->mutex_);
    tell_readers();
  }
  if (started || revived) broker_.look_earlier();
}

void BrokerWriter::assert_liveliness() {
  if (lease_.is_set()) broker_.links_.life(id_);
  {
    const std::lock_guard lock(contract_mutex_);
    if (!lease_.is_set() || !lease_.show_life(broker_.clock_.now())) return;
  }
  {
    const std::lock_guard lock(topic_->mutex_);
    tell_readers();
  }
  broker_.look_earlier();
}

MonotonicTime BrokerWriter::watch(MonotonicTime now) {
  while (!history_.empty() && history_.front()->expires < now) {
    drop_reference(*history_.front());
    history_.pop_front();
  }
  if (!has_contract_) return kNeverExpires;
  bool missed = false, died = false;
  MonotonicTime due;
  {
    const std::lock_guard lock(contract_mutex_);
    if (!is_open()) deadline_.stop();
    if (deadline_.is_set()) {
      const auto late = deadline_.look(now);
      totals_.deadline_missed += late;
      missed = late != 0;
    }
    died = lease_.look(now);
    if (died) ++totals_.liveliness_lost;
    due = std::min(deadline_.due(), lease_.due());
  }
  if (missed || died) tell();
  if (died) tell_readers();
  return due;
}

bool BrokerWriter::is_alive() const {
  const std::lock_guard lock(contract_mutex_);
  return lease_.is_alive();
}

void BrokerWriter::note_matched() {
  {
    const std::lock_guard lock(contract_mutex_);
    ++totals_.matched_total;
  }
  tell();
}

void BrokerWriter::note_clash(const std::string& policy, std::string text) {
  {
    const std::lock_guard lock(contract_mutex_);
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
    if (matches(spec_, reader->spec())) reader->tell();
  }
}

// --- what others read ---------------------------------------------------------------------------------------------------

std::size_t BrokerWriter::reader_count() const {
  const std::lock_guard lock(topic_->mutex_);
  return static_cast<std::size_t>(
      std::ranges::count_if(topic_->readers_, [&](const auto& reader) { return matches(spec_, reader->spec()); }));
}

WriterCounters BrokerWriter::counters() const {
  return {published_.get(), inactive_.get(), would_block_.get(), copies_.get(), bytes_copied_.get(), pool_->made()};
}

EndpointStatus BrokerWriter::status() const {
  const auto matched = static_cast<std::uint32_t>(reader_count());
  const std::lock_guard lock(contract_mutex_);
  EndpointStatus status = totals_;
  status.matched = matched;
  return status;
}

void BrokerWriter::fold_into(Topic::Totals& totals) const {
  const WriterCounters mine = counters();
  totals.written.published += mine.published;
  totals.written.inactive += mine.inactive;
  totals.written.would_block += mine.would_block;
  totals.written.copies += mine.copies;
  totals.written.bytes_copied += mine.bytes_copied;
  totals.written.pool_grown += mine.pool_grown;
  if (mine.published == 0) return;
  totals.first_ns = totals.first_ns == 0 ? first_ns_.get() : std::min(totals.first_ns, first_ns_.get());
  totals.last_ns = std::max(totals.last_ns, last_ns_.get());
}

// --- hand-over ----------------------------------------------------------------------------------------------------------

void BrokerWriter::replay(ReaderQueue& reader) {
  if (!keeps_history_ || !matches(spec_, reader.spec())) return;
  const MonotonicTime now = broker_.clock_.now();
  for (Block* block : history_) {
    if (block->info.sequence <= reader.seen(id_) || block->expires < now) continue;
    if (reader.taking() == Taking::Share) {
      add_reference(*block);
      reader.push(*block);
      continue;
    }
    // Our own pool is the writer's thread's; a joining reader comes on another.
    if (!replay_pool_) replay_pool_ = std::make_unique<MessagePool>(*spec_.type);
    reader.push(copy_of(*block, *replay_pool_));
  }
}

// Under the topic's lock.
void BrokerWriter::refresh_routes() {
  routes_.clear();
  owners_ = 0;
  std::size_t deepest = keeps_history_ ? history_limit_ : 0;
  for (const auto& reader : topic_->readers_) {
    if (!matches(spec_, reader->spec())) continue;
    routes_.push_back(reader);
    if (reader->taking() == Taking::Own) ++owners_;
    deepest = std::max(deepest, reader->spec().qos.resolved().queue_capacity());
  }
  deepest_ = deepest;
  routes_version_ = topic_->version_.load(std::memory_order_relaxed);
}

// The queues of all sharers hold the same last messages, those of each further owner copies of them; beside those, each reader
// has one in its callback and perhaps keeps one, and we fill one.
void BrokerWriter::reserve(const Block& block) {
  if (routes_.empty()) return;
  const std::size_t bytes = spec_.type->size + spec_.type->encoded_size(block.message);
  const std::size_t depth = std::min(deepest_, std::max(kReserveMessages, kReserveBytes / bytes));
  const std::size_t lists = 1 + (owners_ > 1 ? owners_ - 1 : 0);
  pool_->reserve(depth * lists + 2 * routes_.size() + 1, block.message);
}

Block& BrokerWriter::copy_of(const Block& block, MessagePool& pool) {
  Block& copy = *pool.borrow();
  spec_.type->copy_assign(copy.message, block.message);
  copy.info = block.info;
  copy.expires = block.expires;
  copies_.add();
  bytes_copied_.add(spec_.type->encoded_size(block.message));
  return copy;
}

// With a reader (or a history) present every owner gets a copy; with owners only, the last one gets the original.
PublishResult BrokerWriter::distribute(Block& block) {
  const std::size_t sharers = routes_.size() - owners_;
  bool refused = false;
  std::size_t owners_left = owners_;
  const bool original_is_shared = sharers != 0 || keeps_history_;
  if (owners_ != 0) {
    for (const auto& reader : routes_) {
      if (reader->taking() != Taking::Own) continue;
      if (--owners_left == 0 && !original_is_shared) {
        refused |= reader->push(block) == ReaderQueue::Push::Full;
      } else {
        refused |= reader->push(copy_of(block, *pool_)) == ReaderQueue::Push::Full;
      }
    }
    if (!original_is_shared) return answer(refused);
  }
  // One step for all references. Ours keeps the message alive until the last push has been made.
  if (sharers != 0) block.references.fetch_add(static_cast<std::uint32_t>(sharers), std::memory_order_relaxed);
  for (const auto& reader : routes_) {
    if (reader->taking() == Taking::Share) refused |= reader->push(block) == ReaderQueue::Push::Full;
  }
  drop_reference(block);
  return answer(refused);
}

PublishResult BrokerWriter::answer(bool refused) {
  if (!refused || spec_.qos.reliability() == Reliability::BestEffort) return PublishResult::Published;
  would_block_.add();
  return PublishResult::WouldBlock;
}

}  // namespace nacelle::runtime
