// SPDX-License-Identifier: Apache-2.0
#include "fake_transport.hpp"

#include <algorithm>
#include <deque>
#include <new>
#include <optional>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/qos/compatibility.hpp"

namespace nacelle::test {
namespace {

// An envelope on the heap that deletes itself.
struct HeapBlock final : Block, private BlockHome {
  HeapBlock(const msgs::MessageType& t, void* m) : type(t) {
    home = this;
    message = m;
  }
  static void* make_message(const msgs::MessageType& type) {
    void* const memory = type.alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__
                             ? ::operator new (type.size, std::align_val_t{type.alignment})
                             : ::operator new(type.size);
    type.construct(memory);
    return memory;
  }
  void reclaim(Block&) noexcept override {
    type.destroy(message);
    if (type.alignment > __STDCPP_DEFAULT_NEW_ALIGNMENT__) {
      ::operator delete (message, std::align_val_t{type.alignment});
    } else {
      ::operator delete(message);
    }
    delete this;
  }
  const msgs::MessageType& type;
};

Block& copy_of(const Block& block, const msgs::MessageType& type) {
  void* const message = HeapBlock::make_message(type);
  type.copy_assign(message, block.message);
  auto* const copy = new HeapBlock(type, message);
  copy->info = block.info;
  copy->expires = block.expires;
  return *copy;
}

// Periods between two points of time, the last one not counted when it just ends.
std::uint64_t periods(MonotonicTime from, MonotonicTime to, Duration period) {
  return to <= from ? 0 : static_cast<std::uint64_t>((to - from - 1ns) / period);
}

// Deadline by arithmetic over the times of messages; each look adds what is new.
struct Deadline {
  Duration period;
  std::optional<MonotonicTime> last;
  std::uint64_t told = 0, missed = 0;

  bool look(MonotonicTime now) {
    if (period == 0ns || !last) return false;
    const std::uint64_t all = periods(*last, now, period);
    const bool more = all > told;
    missed += more ? all - told : 0;
    told = std::max(told, all);
    return more;
  }
  bool message(MonotonicTime now) {
    const bool more = look(now);
    last = now;
    told = 0;
    return more;
  }
  [[nodiscard]] MonotonicTime due() const {
    return period == 0ns || !last ? kNeverExpires : *last + period * static_cast<Duration::rep>(told + 1) + 1ns;
  }
};

void tell(const EndpointSpec& spec) {
  if (spec.status_listener != nullptr) spec.status_listener->on_status();
}

void note_clash(EndpointStatus& status, const EndpointSpec& writer, const EndpointSpec& reader) {
  if (writer.type != reader.type) {
    ++status.incompatible_type;
    status.last_policy = "type";
    status.last_clash = writer.node + " " + writer.type->name + " " + reader.node + " " + reader.type->name;
    return;
  }
  const auto answer = check(writer.qos.resolved(), reader.qos.resolved());
  ++status.incompatible_qos;
  status.last_policy = answer.clashes.front().policy;
  status.last_clash = writer.node + " " + reader.node + " " + answer.text();
}

bool serves(const EndpointSpec& writer, const QoS& asked) {
  return verdict_of(writer.qos.resolved(), asked.resolved()) != Verdict::Error;
}

bool leaves_to_another(const EndpointSpec& reader, const EndpointSpec& writer) {
  return reader.unless_offered && serves(writer, *reader.unless_offered);
}

bool talk(const EndpointSpec& writer, const EndpointSpec& reader) {
  return writer.topic == reader.topic && writer.type == reader.type && serves(writer, reader.qos) &&
         !leaves_to_another(reader, writer);
}

}  // namespace

class FakeTransport::FakeReader final : public Reader {
 public:
  FakeReader(std::shared_ptr<State> state, EndpointSpec spec, Taking taking, ReadyListener* listener)
      : state_(std::move(state)), spec_(std::move(spec)), taking_(taking), listener_(listener) {}
  ~FakeReader() override {
    const std::lock_guard lock(state_->mutex);
    std::erase(state_->readers, this);
    tell_writers();
    for (Block* block : queue_) drop_reference(*block);
  }
  Block* take() override {
    const std::lock_guard lock(state_->mutex);
    while (!queue_.empty()) {
      Block* const block = queue_.front();
      queue_.pop_front();
      state_->room.notify_all();
      if (block->expires >= state_->clock.now()) {
        ++counters_.delivered;
        return block;
      }
      ++counters_.expired;
      if (spec_.tells_lost) tell(spec_);
      drop_reference(*block);
    }
    return nullptr;
  }
  bool has_waiting() const override {
    const std::lock_guard lock(state_->mutex);
    return !queue_.empty();
  }
  std::size_t writer_count() const override;
  ReaderCounters counters() const override {
    const std::lock_guard lock(state_->mutex);
    return counters_;
  }
  void set_enabled(bool enabled) override;
  void note_latency(Duration) override {}
  void note_rehomed() override { ++counters_.rehomed; }
  EndpointStatus status() const override;
  void tell_writers() const;
  [[nodiscard]] EndpointStatus& totals() { return totals_; }
  [[nodiscard]] Deadline& deadline() { return deadline_; }
  [[nodiscard]] bool is_full() const {
    const QoS qos = spec_.qos.resolved();
    return enabled_ && qos.keeps_all() && queue_.size() >= qos.queue_capacity();
  }

  // Under the lock. Looks at the message; false if it had no room.
  bool offer(Block& block) {
    if (!enabled_) {
      ++counters_.inactive;
      return true;
    }
    const QoS qos = spec_.qos.resolved();
    if (queue_.size() == qos.queue_capacity()) {
      const bool stale = queue_.front()->expires < block.info.source_time;
      if (qos.keeps_all() && !stale) {
        ++counters_.full;
        if (spec_.tells_lost) tell(spec_);
        return false;
      }
      drop_reference(*queue_.front());
      queue_.pop_front();
      ++(stale ? counters_.expired : counters_.overwritten);
      if (spec_.tells_lost) tell(spec_);
    }
    ++counters_.received;
    if (deadline_.message(block.info.source_time)) tell(spec_);
    last_seen_[block.info.writer_id] = block.info.sequence;
    if (taking_ == Taking::Own) {
      queue_.push_back(&copy_of(block, *spec_.type));
    } else {
      add_reference(block);
      queue_.push_back(&block);
    }
    if (listener_ != nullptr) listener_->on_ready();
    return true;
  }
  [[nodiscard]] bool is_enabled() const { return enabled_; }
  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }
  [[nodiscard]] std::uint64_t last_seen(std::uint64_t writer) { return last_seen_[writer]; }

 private:
  const std::shared_ptr<State> state_;
  const EndpointSpec spec_;
  const Taking taking_;
  ReadyListener* const listener_;
  bool enabled_ = spec_.gate == nullptr || spec_.gate->load();
  std::deque<Block*> queue_;
  std::map<std::uint64_t, std::uint64_t> last_seen_;
  EndpointStatus totals_;
  Deadline deadline_{spec_.qos.resolved().deadline(), {}, 0, 0};
  ReaderCounters counters_;
};

class FakeTransport::FakeWriter final : public Writer {
 public:
  FakeWriter(std::shared_ptr<State> state, EndpointSpec spec, std::uint64_t id)
      : state_(std::move(state)), spec_(std::move(spec)), id_(id) {}
  ~FakeWriter() override {
    const std::lock_guard lock(state_->mutex);
    std::erase(state_->writers, this);
    tell_readers();
    for (Block* block : history_) drop_reference(*block);
  }
  Block* borrow() override { return new HeapBlock(*spec_.type, HeapBlock::make_message(*spec_.type)); }
  Block* adopt(void* message) override { return new HeapBlock(*spec_.type, message); }
  PublishResult publish(Block& block) override {
    std::unique_lock lock(state_->mutex);
    if (spec_.gate != nullptr && !spec_.gate->load()) {
      ++counters_.inactive;
      drop_reference(block);
      return PublishResult::Inactive;
    }
    const MonotonicTime now = state_->clock.now();
    const Duration lifespan = spec_.qos.resolved().lifespan();
    block.info = {id_, ++counters_.published, now, now};
    block.expires = lifespan == 0ns ? kNeverExpires : now + lifespan;
    if (deadline_.message(now)) tell(spec_);
    show_life(now);
    if (spec_.qos.reliability() != Reliability::BestEffort) {
      state_->room.wait_for(lock, spec_.qos.max_blocking_time(), [&] {
        return std::ranges::none_of(state_->readers,
                                    [&](const FakeReader* r) { return talk(spec_, r->spec()) && r->is_full(); });
      });
    }
    bool refused = false;
    for (FakeReader* reader : state_->readers) {
      if (talk(spec_, reader->spec())) refused |= !reader->offer(block);
    }
    const QoS qos = spec_.qos.resolved();
    if (qos.durability() == Durability::TransientLocal) {
      add_reference(block);
      history_.push_back(&block);
      if (history_.size() > qos.queue_capacity()) {
        drop_reference(*history_.front());
        history_.pop_front();
      }
    }
    drop_reference(block);
    if (!refused || qos.reliability() == Reliability::BestEffort) return PublishResult::Published;
    ++counters_.would_block;
    return PublishResult::WouldBlock;
  }
  std::size_t reader_count() const override {
    const std::lock_guard lock(state_->mutex);
    return static_cast<std::size_t>(
        std::ranges::count_if(state_->readers, [&](const FakeReader* r) { return talk(spec_, r->spec()); }));
  }
  WriterCounters counters() const override {
    const std::lock_guard lock(state_->mutex);
    return counters_;
  }
  std::uint64_t id() const override { return id_; }
  void assert_liveliness() override {
    const std::lock_guard lock(state_->mutex);
    show_life(state_->clock.now());
  }
  EndpointStatus status() const override {
    EndpointStatus status = totals_;
    status.deadline_missed = deadline_.missed;
    status.matched = static_cast<std::uint32_t>(reader_count());
    return status;
  }
  [[nodiscard]] EndpointStatus& totals() { return totals_; }
  [[nodiscard]] bool is_alive() const { return alive_; }
  void tell_readers() const {
    for (const FakeReader* reader : state_->readers) {
      if (talk(spec_, reader->spec())) tell(reader->spec());
    }
  }
  MonotonicTime watch(MonotonicTime now) {
    if (spec_.gate != nullptr && !spec_.gate->load()) deadline_.last.reset();
    if (deadline_.look(now)) tell(spec_);
    if (lose_life(now)) tell_readers();
    return std::min(deadline_.due(), alive_ && lease() != 0ns ? life_ + lease() + 1ns : kNeverExpires);
  }
  void replay(FakeReader& reader) {
    if (!reader.is_enabled() || !talk(spec_, reader.spec()) ||
        reader.spec().qos.resolved().durability() != Durability::TransientLocal)
      return;
    for (Block* block : history_) {
      if (block->info.sequence > reader.last_seen(id_) && block->expires >= state_->clock.now()) reader.offer(*block);
    }
  }
  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }

 private:
  [[nodiscard]] Duration lease() const {
    const QoS qos = spec_.qos.resolved();
    return qos.liveliness() == Liveliness::ManualByTopic ? qos.liveliness_lease_duration() : 0ns;
  }
  bool lose_life(MonotonicTime now) {
    if (!alive_ || lease() == 0ns || now - life_ <= lease()) return false;
    alive_ = false;
    ++totals_.liveliness_lost;
    tell(spec_);
    return true;
  }
  void show_life(MonotonicTime now) {
    static_cast<void>(lose_life(now));
    life_ = now;
    if (!std::exchange(alive_, true)) tell_readers();
  }
  const std::shared_ptr<State> state_;
  const EndpointSpec spec_;
  const std::uint64_t id_;
  EndpointStatus totals_;
  Deadline deadline_{spec_.qos.resolved().deadline(), {}, 0, 0};
  MonotonicTime life_ = state_->clock.now();
  bool alive_ = true;
  WriterCounters counters_;
  std::deque<Block*> history_;
};

std::size_t FakeTransport::FakeReader::writer_count() const {
  const std::lock_guard lock(state_->mutex);
  return static_cast<std::size_t>(
      std::ranges::count_if(state_->writers, [&](const FakeWriter* w) { return talk(w->spec(), spec_); }));
}

void FakeTransport::FakeReader::set_enabled(bool enabled) {
  const std::lock_guard lock(state_->mutex);
  enabled_ = enabled;
  deadline_.last.reset();
  if (enabled) {
    for (FakeWriter* writer : state_->writers) writer->replay(*this);
    return;
  }
  for (Block* block : queue_) {
    drop_reference(*block);
    ++counters_.inactive;
  }
  queue_.clear();
}

void FakeTransport::FakeReader::tell_writers() const {
  for (const FakeWriter* writer : state_->writers) {
    if (talk(writer->spec(), spec_)) tell(writer->spec());
  }
}

EndpointStatus FakeTransport::FakeReader::status() const {
  const std::lock_guard lock(state_->mutex);
  EndpointStatus status = totals_;
  status.deadline_missed = deadline_.missed;
  status.lost = counters_.overwritten + counters_.full + counters_.expired;
  for (const FakeWriter* writer : state_->writers) {
    if (!talk(writer->spec(), spec_)) continue;
    ++status.matched;
    ++(writer->is_alive() ? status.alive : status.not_alive);
  }
  return status;
}

// watch() reports a clash of types, when all of a node's endpoints are there: it may read both types.
void FakeTransport::State::introduce(FakeWriter& writer, FakeReader& reader) {
  if (writer.spec().topic != reader.spec().topic) return;
  if (writer.spec().type == reader.spec().type && leaves_to_another(reader.spec(), writer.spec())) return;
  if (talk(writer.spec(), reader.spec())) {
    ++writer.totals().matched_total;
    ++reader.totals().matched_total;
  } else {
    note_clash(writer.totals(), writer.spec(), reader.spec());
    note_clash(reader.totals(), writer.spec(), reader.spec());
  }
  tell(writer.spec());
  tell(reader.spec());
}

MonotonicTime FakeTransport::watch(MonotonicTime now) {
  const std::lock_guard lock(state_->mutex);
  MonotonicTime next = kNeverExpires;
  for (FakeWriter* writer : state_->writers) next = std::min(next, writer->watch(now));
  for (FakeReader* reader : state_->readers) {
    if (reader->deadline().look(now)) tell(reader->spec());
    next = std::min(next, reader->deadline().due());
    for (FakeWriter* writer : state_->writers) {
      const bool reads_it = std::ranges::any_of(state_->readers, [&](const FakeReader* other) {
        return other->spec().node == reader->spec().node && other->spec().topic == writer->spec().topic &&
               other->spec().type == writer->spec().type;
      });
      if (writer->spec().type != reader->spec().type && !reads_it && state_->introduced.emplace(writer, reader).second)
        state_->introduce(*writer, *reader);
    }
  }
  return next;
}

std::unique_ptr<Writer> FakeTransport::create_writer(const EndpointSpec& spec) {
  const std::lock_guard lock(state_->mutex);
  auto writer = std::make_unique<FakeWriter>(state_, spec, state_->next_id++);
  state_->writers.push_back(writer.get());
  for (FakeReader* reader : state_->readers) {
    if (reader->spec().type == spec.type) state_->introduce(*writer, *reader);
  }
  return writer;
}

std::unique_ptr<Reader> FakeTransport::create_reader(const EndpointSpec& spec, Taking taking, ReadyListener* listener) {
  const std::lock_guard lock(state_->mutex);
  auto reader = std::make_unique<FakeReader>(state_, spec, taking, listener);
  state_->readers.push_back(reader.get());
  for (FakeWriter* writer : state_->writers) {
    if (writer->spec().type == spec.type) state_->introduce(*writer, *reader);
  }
  for (FakeWriter* writer : state_->writers) writer->replay(*reader);
  return reader;
}

}  // namespace nacelle::test
