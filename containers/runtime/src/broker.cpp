// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/broker.hpp"

#include <unistd.h>

#include <algorithm>

#include "broker_writer.hpp"
#include "message_library.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "qos_clash.hpp"
#include "qos_watch.hpp"

namespace nacelle::runtime {
namespace {

// The report still shows topics without endpoints. Their number is limited, because a caller can open any number of
// names.
constexpr std::size_t kMostUnusedTopics = 256;

// Messages carry their writer's id to other processes (graph.hpp).
std::uint64_t first_id() {
  static std::atomic<std::uint64_t> brokers{0};
  return (static_cast<std::uint64_t>(::getpid()) << 40U) | ((brokers.fetch_add(1) & 0xFFU) << 32U) | 1U;
}

}  // namespace

class BrokerReader final : public ProxyReader {
 public:
  BrokerReader(Broker& broker, std::shared_ptr<Topic> topic, std::shared_ptr<ReaderQueue> queue)
      : broker_(broker), topic_(std::move(topic)), queue_(std::move(queue)) {
    const LockGuard lock(topic_->mutex_);
    topic_->readers_.push_back(queue_);
    topic_->version_.fetch_add(1, std::memory_order_release);
    for (BrokerWriter* writer : topic_->writers_) introduce(*writer, *queue_);
    replay();
  }
  ~BrokerReader() override {
    queue_->close();
    leave();
    if (is_whole_) broker_.note_end(*topic_);
  }
  /// From now on its destruction takes the broker's lock.
  void be_whole() { is_whole_ = true; }

  Block* take() override { return queue_->take(); }
  bool has_waiting() const override { return queue_->has_waiting(); }
  std::size_t writer_count() const override {
    const LockGuard lock(topic_->mutex_);
    return static_cast<std::size_t>(std::ranges::count_if(
        topic_->writers_, [&](const BrokerWriter* writer) { return matches(writer->spec(), queue_->spec()); }));
  }
  ReaderCounters counters() const override { return queue_->counters(); }
  EndpointStatus status() const override {
    EndpointStatus status = queue_->status();
    const LockGuard lock(topic_->mutex_);
    for (const BrokerWriter* writer : topic_->writers_) {
      if (!matches(writer->spec(), queue_->spec())) continue;
      ++status.matched;
      ++(writer->is_alive() ? status.alive : status.not_alive);
    }
    return status;
  }
  void set_enabled(bool enabled) override {
    queue_->set_enabled(enabled);
    broker_.links_.gate(queue_->id(), enabled);
    if (!enabled || !queue_->wants_history()) return;
    // Messages published while the gate was closed are history for a reader that requests it.
    const LockGuard lock(topic_->mutex_);
    replay();
  }
  void set_lender(std::shared_ptr<BufferLender> lender) override {
    const LockGuard lock(topic_->mutex_);
    queue_->set_lender(std::move(lender));
    topic_->version_.fetch_add(1, std::memory_order_release);
  }
  void note_latency(Duration latency) override { queue_->note_latency(latency); }
  const DurationHistogram* latency() const override { return &queue_->latency(); }
  void note_rehomed() override { queue_->note_rehomed(); }

  Block* look() override { return queue_->look(); }
  void release(std::uint64_t messages) override { queue_->release(messages); }
  void forget_seen() override { queue_->forget_seen(); }
  void note_copied(std::uint64_t bytes) override {
    const LockGuard lock(topic_->mutex_);
    ++topic_->gone_.written.copies;
    topic_->gone_.written.bytes_copied += bytes;
  }

 private:
  void replay() NACELLE_REQUIRES(topic_->mutex_) {
    if (!queue_->wants_history() || !queue_->is_enabled()) return;
    for (BrokerWriter* writer : topic_->writers_) writer->replay(*queue_);
  }
  void leave() {
    const LockGuard lock(topic_->mutex_);
    topic_->gone_.handed_over = handed_over(*topic_);
    std::erase(topic_->readers_, queue_);
    topic_->version_.fetch_add(1, std::memory_order_release);
    for (BrokerWriter* writer : topic_->writers_) {
      if (writer->is_read_by(*queue_)) writer->tell();
    }
    broker_.links_.gone(queue_->id());
    if (is_tool(queue_->spec())) return;
    add(topic_->gone_.read, queue_->counters());
    if (queue_->latency().count() != 0) {
      if (!topic_->gone_.latency) topic_->gone_.latency = std::make_unique<DurationHistogram>();
      topic_->gone_.latency->merge(queue_->latency());
    }
  }

  Broker& broker_;
  const std::shared_ptr<Topic> topic_;
  const std::shared_ptr<ReaderQueue> queue_;
  bool is_whole_ = false;
};

Broker::Broker(const Clock& clock, Watching watching) : clock_(clock), next_id_(first_id()) {
  if (watching == Watching::ByThread)
    qos_watch_ = std::make_unique<QosWatch>([this](MonotonicTime now) { return watch(now); });
}
Broker::~Broker() = default;

void Broker::look_earlier() {
  if (qos_watch_) qos_watch_->poke();
}

MonotonicTime Broker::watch(MonotonicTime now) {
  const LockGuard lock(mutex_);
  MonotonicTime next = kNeverExpires;
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    for (BrokerWriter* writer : topic->writers_) next = std::min(next, writer->watch(now));
    for (const auto& reader : topic->readers_) next = std::min(next, reader->watch(now));
  }
  if (std::exchange(types_to_compare_, false)) tell_type_clashes();
  return next;
}

std::shared_ptr<Topic> Broker::topic(const EndpointSpec& spec) {
  const auto found = topics_.find({spec.topic, spec.type});
  if (found == topics_.end()) {
    pin_library_of(*spec.type);
    auto made = std::make_shared<Topic>(spec.topic, *spec.type);
    topics_.emplace(std::pair{spec.topic, spec.type}, made);
    return made;
  }
  const std::shared_ptr<Topic>& known = found->second;
  if (known->place_unused_) {
    unused_.erase(*known->place_unused_);
    known->place_unused_.reset();
  }
  return known;
}

// Called when an endpoint has left the topic. Endpoints are made under the broker's lock, so a topic that is found
// empty stays empty meanwhile.
void Broker::note_end(Topic& topic) {
  const LockGuard lock(mutex_);
  {
    const LockGuard topic_lock(topic.mutex_);
    if (topic.place_unused_ || !topic.writers_.empty() || !topic.readers_.empty()) return;
  }
  // If two endpoints end at once, the second may find the topic already removed.
  const auto found = topics_.find({topic.name_, &topic.type_});
  if (found == topics_.end() || found->second.get() != &topic) return;
  topic.place_unused_ = unused_.insert(unused_.end(), &topic);
  if (unused_.size() <= kMostUnusedTopics) return;
  const Topic& oldest = *unused_.front();
  unused_.pop_front();
  topics_.erase({oldest.name_, &oldest.type_});
}

std::unique_ptr<Writer> Broker::create_writer(const EndpointSpec& spec) {
  const LockGuard lock(mutex_);
  return make_writer(spec, next_id_++);
}

// Under the lock.
std::unique_ptr<ProxyWriter> Broker::make_writer(const EndpointSpec& spec, std::uint64_t id) {
  types_to_compare_ = true;
  auto writer = std::make_unique<BrokerWriter>(*this, topic(spec), spec, id);
  links_.made(info_of(spec, id, true, true));
  writer->be_whole();
  return writer;
}

std::unique_ptr<Reader> Broker::create_reader(const EndpointSpec& spec, Taking taking, ReadyListener* listener) {
  const LockGuard lock(mutex_);
  const std::uint64_t id = next_id_++;
  return make_reader(std::make_shared<ReaderQueue>(spec, taking, listener, clock_, qos_watch_.get(), id));
}

std::unique_ptr<Reader> Broker::create_reader(const EndpointSpec& spec, Taking taking, Executable& executable) {
  const LockGuard lock(mutex_);
  const std::uint64_t id = next_id_++;
  return make_reader(std::make_shared<ReaderQueue>(spec, taking, executable, clock_, qos_watch_.get(), id));
}

std::unique_ptr<ProxyReader> Broker::create_proxy_reader(const EndpointSpec& spec, ReadyListener* listener) {
  const LockGuard lock(mutex_);
  const std::uint64_t id = next_id_++;
  return make_reader(std::make_shared<ReaderQueue>(spec, Taking::Share, listener, clock_, qos_watch_.get(), id));
}

// Under the lock.
std::unique_ptr<ProxyReader> Broker::make_reader(std::shared_ptr<ReaderQueue> queue) {
  types_to_compare_ = true;
  queue->tell_links(&links_);
  auto reader = std::make_unique<BrokerReader>(*this, topic(queue->spec()), queue);
  if (!queue->is_tap() && !queue->is_witness())
    links_.made(info_of(queue->spec(), queue->id(), false, queue->is_enabled()));
  reader->be_whole();
  return reader;
}

void Broker::retire(const EndpointSpec& spec, std::unique_ptr<MessagePool> pool) {
  if (pool->outstanding() == 0) return;
  const LockGuard lock(mutex_);
  // Pools of proxies, which come and go with their peers, are swept only here.
  drop_what_is_home();
  retired_.push_back({spec.node, spec.topic, std::move(pool)});
}

void Broker::drop_what_is_home() {
  std::erase_if(retired_, [](const Retired& retired) { return retired.pool->outstanding() == 0; });
}

std::string Broker::sweep(const std::vector<std::string>& nodes) {
  const LockGuard lock(mutex_);
  drop_what_is_home();
  for (const auto& retired : retired_) {
    if (std::ranges::find(nodes, retired.node) == nodes.end()) continue;
    const auto n = retired.pool->outstanding();
    return std::to_string(n) + (n == 1 ? " message of " : " messages of ") + retired.topic;
  }
  return {};
}

const msgs::MessageType* Broker::topic_type(const std::string& name) const {
  const LockGuard lock(mutex_);
  const msgs::MessageType* read_only = nullptr;
  for (const auto& [key, topic] : topics_) {
    if (key.first != name) continue;
    const LockGuard topic_lock(topic->mutex_);
    // Of two types on one name, the one that is published.
    if (!topic->writers_.empty()) return key.second;
    if (!topic->readers_.empty() && read_only == nullptr) read_only = key.second;
  }
  return read_only;
}

}  // namespace nacelle::runtime
