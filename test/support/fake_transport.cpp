// SPDX-License-Identifier: Apache-2.0
#include "fake_transport.hpp"

#include <algorithm>
#include <deque>
#include <new>

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
  return *copy;
}

bool talk(const EndpointSpec& writer, const EndpointSpec& reader) {
  return writer.topic == reader.topic && writer.type == reader.type &&
         verdict_of(writer.qos.resolved(), reader.qos.resolved()) != Verdict::Error;
}

}  // namespace

class FakeTransport::FakeReader final : public Reader {
 public:
  FakeReader(std::shared_ptr<State> state, EndpointSpec spec, Taking taking, ReadyListener* listener)
      : state_(std::move(state)), spec_(std::move(spec)), taking_(taking), listener_(listener) {}
  ~FakeReader() override {
    const std::lock_guard lock(state_->mutex);
    std::erase(state_->readers, this);
    for (Block* block : queue_) drop_reference(*block);
  }
  Block* take() override {
    const std::lock_guard lock(state_->mutex);
    if (queue_.empty()) return nullptr;
    Block* const block = queue_.front();
    queue_.pop_front();
    ++counters_.delivered;
    return block;
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

  // Under the lock. Looks at the message; false if it had no room.
  bool offer(Block& block) {
    if (!enabled_) {
      ++counters_.inactive;
      return true;
    }
    const QoS qos = spec_.qos.resolved();
    if (queue_.size() == qos.queue_capacity()) {
      if (qos.keeps_all()) {
        ++counters_.full;
        return false;
      }
      drop_reference(*queue_.front());
      queue_.pop_front();
      ++counters_.overwritten;
    }
    ++counters_.received;
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
  ReaderCounters counters_;
};

class FakeTransport::FakeWriter final : public Writer {
 public:
  FakeWriter(std::shared_ptr<State> state, EndpointSpec spec, std::uint64_t id)
      : state_(std::move(state)), spec_(std::move(spec)), id_(id) {}
  ~FakeWriter() override {
    const std::lock_guard lock(state_->mutex);
    std::erase(state_->writers, this);
    for (Block* block : history_) drop_reference(*block);
  }
  Block* borrow() override { return new HeapBlock(*spec_.type, HeapBlock::make_message(*spec_.type)); }
  Block* adopt(void* message) override { return new HeapBlock(*spec_.type, message); }
  PublishResult publish(Block& block) override {
    const std::lock_guard lock(state_->mutex);
    if (spec_.gate != nullptr && !spec_.gate->load()) {
      ++counters_.inactive;
      drop_reference(block);
      return PublishResult::Inactive;
    }
    block.info = {id_, ++counters_.published, state_->clock.now(), state_->clock.now()};
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
  void replay(FakeReader& reader) {
    if (!reader.is_enabled() || !talk(spec_, reader.spec()) ||
        reader.spec().qos.resolved().durability() != Durability::TransientLocal)
      return;
    for (Block* block : history_) {
      if (block->info.sequence > reader.last_seen(id_)) reader.offer(*block);
    }
  }
  [[nodiscard]] const EndpointSpec& spec() const { return spec_; }

 private:
  const std::shared_ptr<State> state_;
  const EndpointSpec spec_;
  const std::uint64_t id_;
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

std::unique_ptr<Writer> FakeTransport::create_writer(const EndpointSpec& spec) {
  const std::lock_guard lock(state_->mutex);
  auto writer = std::make_unique<FakeWriter>(state_, spec, state_->next_id++);
  state_->writers.push_back(writer.get());
  return writer;
}

std::unique_ptr<Reader> FakeTransport::create_reader(const EndpointSpec& spec, Taking taking, ReadyListener* listener) {
  const std::lock_guard lock(state_->mutex);
  auto reader = std::make_unique<FakeReader>(state_, spec, taking, listener);
  state_->readers.push_back(reader.get());
  for (FakeWriter* writer : state_->writers) writer->replay(*reader);
  return reader;
}

}  // namespace nacelle::test
