// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/broker.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <deque>

#include "broker_reader.hpp"
#include "nacelle/qos/compatibility.hpp"

namespace nacelle::runtime {
namespace {

// What a deep queue may need is made at once while it is small; beyond that, a burst of large messages pays when it comes.
constexpr std::size_t kReserveMessages = 16, kReserveBytes = std::size_t{512} * 1024;

// A counter with one writing thread: a load and a store, no locked instruction.
class Tally {
 public:
  void add(std::uint64_t n = 1) { value_.store(value_.load(std::memory_order_relaxed) + n, std::memory_order_relaxed); }
  void set(std::uint64_t n) { value_.store(n, std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t get() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

// Message libraries stay for the life of the process: types, pools and queued messages refer to them (design D4).
void pin_library_of(const msgs::MessageType& type) {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(type.construct), &info) != 0 && info.dli_fname != nullptr) {
    static_cast<void>(dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE));
  }
}

// A look from outside the robot (topic echo): it must not change what the report says of the robot's own streams.
bool is_tool(const EndpointSpec& spec) { return spec.node.empty(); }

bool matches(const EndpointSpec& writer, const EndpointSpec& reader) {
  return verdict_of(writer.qos.resolved(), reader.qos.resolved()) != Verdict::Error;
}

}  // namespace

class BrokerWriter;

/// One name with one type.
class Topic {
 public:
  Topic(std::string name, const msgs::MessageType& type) : name_(std::move(name)), type_(type) {}

  struct Totals {
    WriterCounters written;
    ReaderCounters read;
    std::unique_ptr<DurationHistogram> latency;
    std::uint64_t first_ns = 0, last_ns = 0;
  };

  const std::string name_;
  const msgs::MessageType& type_;
  std::atomic<std::uint64_t> version_{1};
  mutable std::mutex mutex_;
  std::vector<BrokerWriter*> writers_;
  std::vector<std::shared_ptr<ReaderQueue>> readers_;
  Totals gone_;  // of endpoints that were taken out
};

class BrokerWriter final : public Writer {
 public:
  BrokerWriter(Broker& broker, std::shared_ptr<Topic> topic, EndpointSpec spec, std::uint64_t id)
      : broker_(broker),
        topic_(std::move(topic)),
        spec_(std::move(spec)),
        id_(id),
        keeps_history_(spec_.qos.resolved().durability() == Durability::TransientLocal),
        history_limit_(std::max<std::size_t>(1, spec_.qos.resolved().queue_capacity())),
        pool_(std::make_unique<MessagePool>(*spec_.type)) {
    const std::lock_guard lock(topic_->mutex_);
    topic_->writers_.push_back(this);
    // A writer that joins a running graph makes its messages now, not in the middle of its first publish().
    refresh_routes();
    Block* const blank = pool_->borrow();
    reserve(*blank);
    drop_reference(*blank);
  }

  ~BrokerWriter() override {
    {
      const std::lock_guard lock(topic_->mutex_);
      std::erase(topic_->writers_, this);
      for (const auto& reader : topic_->readers_) reader->forget_writer(id_);
      fold_into(topic_->gone_);
    }
    for (Block* block : history_) drop_reference(*block);
    broker_.retire(spec_, std::move(pool_));
  }

  Block* borrow() override { return pool_->borrow(); }
  Block* adopt(void* message) override { return pool_->adopt(message); }

  PublishResult publish(Block& block) override {
    if (spec_.gate != nullptr && !spec_.gate->load(std::memory_order_acquire)) {
      inactive_.add();
      drop_reference(block);
      return PublishResult::Inactive;
    }
    const MonotonicTime now = broker_.clock_.now();
    const std::uint64_t sequence = published_.get() + 1;
    block.info = {id_, sequence, now, now};
    if (sequence == 1) {
      first_ns_.set(static_cast<std::uint64_t>(now.nanoseconds()));
      pool_->warm(block.message);
    }
    last_ns_.set(static_cast<std::uint64_t>(now.nanoseconds()));
    published_.set(sequence);
    if (!keeps_history_) {
      if (topic_->version_.load(std::memory_order_acquire) != routes_version_) {
        const std::lock_guard lock(topic_->mutex_);
        refresh_routes();
        reserve(block);
      }
      return distribute(block);
    }
    // A late joiner is served under the same lock, so that it gets each message once and in order.
    const std::lock_guard lock(topic_->mutex_);
    if (topic_->version_.load(std::memory_order_relaxed) != routes_version_) {
      refresh_routes();
      reserve(block);
    }
    add_reference(block);
    history_.push_back(&block);
    if (history_.size() > history_limit_) {
      drop_reference(*history_.front());
      history_.pop_front();
    }
    return distribute(block);
  }

  std::size_t reader_count() const override {
    const std::lock_guard lock(topic_->mutex_);
    return static_cast<std::size_t>(
        std::ranges::count_if(topic_->readers_, [&](const auto& reader) { return matches(spec_, reader->spec()); }));
  }
  WriterCounters counters() const override {
    return {published_.get(), inactive_.get(), would_block_.get(), copies_.get(), bytes_copied_.get(), pool_->made()};
  }
  std::uint64_t id() const override { return id_; }

  /// Under the topic's lock: gives a reader what it has not seen of the history.
  void replay(ReaderQueue& reader) {
    if (!keeps_history_ || !matches(spec_, reader.spec())) return;
    for (Block* block : history_) {
      if (block->info.sequence <= reader.seen(id_)) continue;
      if (reader.taking() == Taking::Own) {
        reader.push(copy_of(*block));
      } else {
        add_reference(*block);
        reader.push(*block);
      }
    }
  }

  void fold_into(Topic::Totals& totals) const {
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

  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }

 private:
  // Under the topic's lock.
  void refresh_routes() {
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
  void reserve(const Block& block) {
    if (routes_.empty()) return;
    const std::size_t bytes = spec_.type->size + spec_.type->encoded_size(block.message);
    const std::size_t depth = std::min(deepest_, std::max(kReserveMessages, kReserveBytes / bytes));
    const std::size_t lists = 1 + (owners_ > 1 ? owners_ - 1 : 0);
    pool_->reserve(depth * lists + 2 * routes_.size() + 1, block.message);
  }

  Block& copy_of(const Block& block) {
    Block& copy = *pool_->borrow();
    spec_.type->copy_assign(copy.message, block.message);
    copy.info = block.info;
    copies_.add();
    bytes_copied_.add(spec_.type->encoded_size(block.message));
    return copy;
  }

  // With a reader (or a history) present every owner gets a copy; with owners only, the last one gets the original.
  PublishResult distribute(Block& block) {
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
          refused |= reader->push(copy_of(block)) == ReaderQueue::Push::Full;
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

  PublishResult answer(bool refused) {
    if (!refused || spec_.qos.reliability() == Reliability::BestEffort) return PublishResult::Published;
    would_block_.add();
    return PublishResult::WouldBlock;
  }

  Broker& broker_;
  const std::shared_ptr<Topic> topic_;
  const EndpointSpec spec_;
  const std::uint64_t id_;
  const bool keeps_history_;
  const std::size_t history_limit_;
  std::unique_ptr<MessagePool> pool_;
  std::vector<std::shared_ptr<ReaderQueue>> routes_;
  std::size_t owners_ = 0;
  std::size_t deepest_ = 0;
  std::uint64_t routes_version_ = 0;
  std::deque<Block*> history_;
  Tally published_, inactive_, would_block_, copies_, bytes_copied_, first_ns_, last_ns_;
};

namespace {

class BrokerReader final : public Reader {
 public:
  BrokerReader(std::shared_ptr<Topic> topic, std::shared_ptr<ReaderQueue> queue)
      : topic_(std::move(topic)), queue_(std::move(queue)) {
    const std::lock_guard lock(topic_->mutex_);
    topic_->readers_.push_back(queue_);
    topic_->version_.fetch_add(1, std::memory_order_release);
    replay();
  }
  ~BrokerReader() override {
    queue_->close();
    const std::lock_guard lock(topic_->mutex_);
    std::erase(topic_->readers_, queue_);
    topic_->version_.fetch_add(1, std::memory_order_release);
    if (is_tool(queue_->spec())) return;
    add(topic_->gone_.read, queue_->counters());
    if (queue_->latency().count() != 0) {
      if (!topic_->gone_.latency) topic_->gone_.latency = std::make_unique<DurationHistogram>();
      topic_->gone_.latency->merge(queue_->latency());
    }
  }

  Block* take() override { return queue_->take(); }
  bool has_waiting() const override { return queue_->has_waiting(); }
  std::size_t writer_count() const override {
    const std::lock_guard lock(topic_->mutex_);
    return static_cast<std::size_t>(std::ranges::count_if(
        topic_->writers_, [&](const BrokerWriter* writer) { return matches(writer->spec(), queue_->spec()); }));
  }
  ReaderCounters counters() const override { return queue_->counters(); }
  void set_enabled(bool enabled) override {
    queue_->set_enabled(enabled);
    if (!enabled || !queue_->wants_history()) return;
    // What was published while the gate was closed counts as history to a reader that asked for it.
    const std::lock_guard lock(topic_->mutex_);
    replay();
  }
  void note_latency(Duration latency) override { queue_->note_latency(latency); }
  void note_rehomed() override { queue_->note_rehomed(); }

  static void add(ReaderCounters& to, const ReaderCounters& c) {
    to.received += c.received;
    to.delivered += c.delivered;
    to.overwritten += c.overwritten;
    to.full += c.full;
    to.inactive += c.inactive;
    to.discarded += c.discarded;
    to.rehomed += c.rehomed;
  }

 private:
  void replay() {
    if (!queue_->wants_history() || !queue_->is_enabled()) return;
    for (BrokerWriter* writer : topic_->writers_) writer->replay(*queue_);
  }
  const std::shared_ptr<Topic> topic_;
  const std::shared_ptr<ReaderQueue> queue_;
};

}  // namespace

Broker::Broker(const Clock& clock) : clock_(clock) {}
Broker::~Broker() = default;

std::shared_ptr<Topic> Broker::topic(const EndpointSpec& spec) {
  auto& slot = topics_[{spec.topic, spec.type}];
  if (!slot) {
    pin_library_of(*spec.type);
    slot = std::make_shared<Topic>(spec.topic, *spec.type);
  }
  return slot;
}

std::unique_ptr<Writer> Broker::create_writer(const EndpointSpec& spec) {
  const std::lock_guard lock(mutex_);
  return std::make_unique<BrokerWriter>(*this, topic(spec), spec, next_writer_id_++);
}

std::unique_ptr<Reader> Broker::create_reader(const EndpointSpec& spec, Taking taking, ReadyListener* listener) {
  const std::lock_guard lock(mutex_);
  return std::make_unique<BrokerReader>(topic(spec), std::make_shared<ReaderQueue>(spec, taking, listener));
}

void Broker::retire(const EndpointSpec& spec, std::unique_ptr<MessagePool> pool) {
  if (pool->outstanding() == 0) return;
  const std::lock_guard lock(mutex_);
  retired_.push_back({spec.node, spec.topic, std::move(pool)});
}

std::string Broker::sweep(const std::string& node) {
  const std::lock_guard lock(mutex_);
  std::erase_if(retired_, [](const Retired& retired) { return retired.pool->outstanding() == 0; });
  for (const auto& retired : retired_) {
    if (retired.node != node) continue;
    const auto n = retired.pool->outstanding();
    return std::to_string(n) + (n == 1 ? " message of " : " messages of ") + retired.topic;
  }
  return {};
}

const msgs::MessageType* Broker::topic_type(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const msgs::MessageType* read_only = nullptr;
  for (const auto& [key, topic] : topics_) {
    if (key.first != name) continue;
    const std::lock_guard topic_lock(topic->mutex_);
    // Of two types on one name, the one that somebody sends.
    if (!topic->writers_.empty()) return key.second;
    if (!topic->readers_.empty() && read_only == nullptr) read_only = key.second;
  }
  return read_only;
}

std::vector<ClashReport> Broker::clashes() const {
  struct Ends {
    const msgs::MessageType* type;
    std::vector<EndpointSpec> writers, readers;
  };
  std::map<std::string, std::vector<Ends>> by_name;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, topic] : topics_) {
      const std::lock_guard topic_lock(topic->mutex_);
      Ends ends{key.second, {}, {}};
      for (const BrokerWriter* writer : topic->writers_) ends.writers.push_back(writer->spec());
      for (const auto& reader : topic->readers_) ends.readers.push_back(reader->spec());
      by_name[key.first].push_back(std::move(ends));
    }
  }
  std::vector<ClashReport> found;
  for (const auto& [name, types] : by_name) {
    for (const auto& from : types) {
      for (const auto& to : types) {
        for (const auto& writer : from.writers) {
          for (const auto& reader : to.readers) {
            if (&from == &to) {
              for (auto& clash : check(writer.qos.resolved(), reader.qos.resolved()).clashes) {
                if (clash.severity != Verdict::Error) continue;
                found.push_back(
                    {name, writer.node, reader.node, clash.policy, clash.offered, clash.requested, clash.change});
              }
            } else if (!std::ranges::any_of(from.readers,
                                            [&](const EndpointSpec& r) { return r.node == reader.node; })) {
              // Silent only for a node that reads both types, as a base takes Twist and TwistStamped on one name.
              found.push_back({name, writer.node, reader.node, "type", from.type->name, to.type->name,
                               "rename one of the topics with a remap, or make both sides use one type"});
            }
          }
        }
      }
    }
  }
  return found;
}

void Broker::report(std::vector<StreamReport>& out) const {
  const std::lock_guard lock(mutex_);
  std::size_t used = 0;
  for (const auto& [key, topic] : topics_) {
    const std::lock_guard topic_lock(topic->mutex_);
    Topic::Totals sum;
    sum.written = topic->gone_.written;
    sum.read = topic->gone_.read;
    sum.first_ns = topic->gone_.first_ns;
    sum.last_ns = topic->gone_.last_ns;
    DurationHistogram latency;
    if (topic->gone_.latency) latency.merge(*topic->gone_.latency);
    for (const BrokerWriter* writer : topic->writers_) writer->fold_into(sum);
    std::size_t readers = 0;
    for (const auto& reader : topic->readers_) {
      if (is_tool(reader->spec())) continue;
      ++readers;
      BrokerReader::add(sum.read, reader->counters());
      latency.merge(reader->latency());
    }
    if (used == out.size()) out.emplace_back();
    StreamReport& row = out[used++];
    row.name = key.first;
    row.type = key.second->name;
    row.published = sum.written.published;
    row.delivered = sum.read.delivered;
    row.writers = topic->writers_.size();
    row.readers = readers;
    row.first = {Duration{static_cast<std::int64_t>(sum.first_ns)}};
    row.last = {Duration{static_cast<std::int64_t>(sum.last_ns)}};
    row.overwritten = sum.read.overwritten;
    row.full = sum.read.full;
    row.inactive = sum.read.inactive;
    row.discarded = sum.read.discarded;
    row.rehomed = sum.read.rehomed;
    row.would_block = sum.written.would_block;
    row.inactive_unpublished = sum.written.inactive;
    row.copies = sum.written.copies;
    row.bytes_copied = sum.written.bytes_copied;
    row.latency_p50 = latency.quantile(0.5);
    row.latency_p99 = latency.quantile(0.99);
    row.latency_max = latency.max();
  }
  out.resize(used);
}

}  // namespace nacelle::runtime
