// SPDX-License-Identifier: Apache-2.0
// The broker's services for links to other processes: reporting endpoints to them, and passing on their messages.
#include <algorithm>

#include "broker_writer.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "qos_clash.hpp"

namespace nacelle::runtime {
namespace {

/// A reader without a queue, which only takes part in matching and counting.
class BrokerWitness final : public Witness {
 public:
  BrokerWitness(std::shared_ptr<Topic> topic, std::shared_ptr<ReaderQueue> queue, std::unique_ptr<ProxyReader> reader)
      : topic_(std::move(topic)), queue_(std::move(queue)), reader_(std::move(reader)) {}
  void count_for(std::uint64_t id, bool counts) override {
    const LockGuard lock(topic_->mutex_);
    if (!queue_->count_for(id, counts)) return;
    for (BrokerWriter* writer : topic_->writers_) {
      if (writer->id() != id || !matches(writer->spec(), queue_->spec())) continue;
      if (counts) {
        writer->note_matched();
      } else {
        writer->tell();
      }
    }
  }

 private:
  const std::shared_ptr<Topic> topic_;
  const std::shared_ptr<ReaderQueue> queue_;
  const std::unique_ptr<ProxyReader> reader_;
};

}  // namespace

EndpointInfo info_of(const EndpointSpec& spec, std::uint64_t id, bool is_writer, bool open) {
  EndpointInfo info{id, is_writer, open, spec};
  info.spec.gate = nullptr;
  info.spec.status_listener = nullptr;
  info.spec.on_fault = {};
  return info;
}

std::uint32_t Broker::join(GraphListener& listener) {
  const LockGuard lock(mutex_);
  const std::uint32_t link = next_link_++;
  // Before the endpoints are read: none is made under the broker's lock, and one that ends meanwhile is reported
  // afterwards, or is not seen.
  links_.add(link, listener);
  for (const auto& [key, topic] : topics_) {
    const LockGuard topic_lock(topic->mutex_);
    for (const BrokerWriter* writer : topic->writers_)
      listener.on_made(info_of(writer->spec(), writer->id(), true, true));
    for (const auto& reader : topic->readers_) {
      if (!reader->is_tap() && !reader->is_witness())
        listener.on_made(info_of(reader->spec(), reader->id(), false, reader->is_enabled()));
    }
  }
  return link;
}

void Broker::leave(std::uint32_t link) { links_.remove(link); }

std::unique_ptr<ProxyWriter> Broker::create_proxy_writer(const EndpointSpec& spec, std::uint64_t id) {
  const LockGuard lock(mutex_);
  return make_writer(spec, id);
}

std::unique_ptr<ProxyReader> Broker::create_tap(const EndpointInfo& writer, std::uint32_t link,
                                                ReadyListener* listener) {
  EndpointSpec spec;
  spec.topic = writer.spec.topic;
  spec.type = writer.spec.type;
  spec.qos = writer.spec.qos.resolved();
  spec.qos.keep_last(std::max<std::size_t>(1, spec.qos.queue_capacity()));
  spec.via = link;
  std::unique_ptr<ProxyReader> tap;  // if something throws, it ends after the lock
  const LockGuard lock(mutex_);
  auto queue = std::make_shared<ReaderQueue>(spec, Taking::Share, listener, clock_, qos_watch_.get(), next_id_++);
  queue->be_tap_of(writer.id);
  tap = make_reader(queue);
  // A process sends only topics with a reader here, and other processes need not know this reader.
  if (writer.spec.via != 0) links_.made(info_of(spec, queue->id(), false, true), writer.spec.via);
  return tap;
}

std::unique_ptr<Witness> Broker::create_witness(const EndpointSpec& spec) {
  static constexpr std::atomic<bool> kClosed{false};
  EndpointSpec closed = spec;
  closed.gate = &kClosed;
  std::unique_ptr<ProxyReader> reader;  // if something throws, it ends after the lock
  const LockGuard lock(mutex_);
  auto queue = std::make_shared<ReaderQueue>(closed, Taking::Share, nullptr, clock_, qos_watch_.get(), next_id_++);
  queue->be_witness();
  reader = make_reader(queue);
  return std::make_unique<BrokerWitness>(topic(closed), std::move(queue), std::move(reader));
}

void Broker::note_lost(const EndpointInfo& reader, const ReaderCounters& losses) {
  const LockGuard lock(mutex_);
  const auto found = topics_.find({reader.spec.topic, reader.spec.type});
  if (found == topics_.end()) return;
  const LockGuard topic_lock(found->second->mutex_);
  for (const auto& queue : found->second->readers_) {
    if (queue->id() == reader.id) queue->note_lost(losses);
  }
}

void Broker::note_other_type(const EndpointInfo& ours, const std::string& node, const std::string& type) {
  const EndpointSpec& spec = ours.spec;
  if (is_tool(spec)) return;
  const ClashReport clash = ours.is_writer ? clash_of_types(spec.topic, spec.node, spec.type->name, node, type)
                                           : clash_of_types(spec.topic, node, type, spec.node, spec.type->name);
  const LockGuard lock(mutex_);
  const auto found = topics_.find({spec.topic, spec.type});
  if (found == topics_.end()) return;
  const LockGuard topic_lock(found->second->mutex_);
  for (BrokerWriter* writer : found->second->writers_) {
    if (writer->id() == ours.id) writer->note_clash(kTypePolicy, clash.text());
  }
  for (const auto& queue : found->second->readers_) {
    if (queue->id() == ours.id) queue->note_clash(kTypePolicy, clash.text());
  }
}

// --- handing on ---------------------------------------------------------------------------------------------------------

void BrokerWriter::pass_on(ReaderQueue& reader, Block& block) {
  if (reader.push(block) != ReaderQueue::Push::Queued && reader.keeps_all())
    broker_.links_.left(reader.id(), spec_.via);
}

void BrokerWriter::relay(Block& block, const MessageInfo& info, MonotonicTime expires,
                         std::span<const std::uint64_t> readers, std::uint64_t bytes_copied) {
  block.info = info;
  block.info.received_time = broker_.clock_.now();
  block.expires = expires;
  block.via = spec_.via;
  thread_.set(this_thread_mark());
  // History sent for a late joiner was counted when it was new.
  if (info.sequence > last_relayed_) {
    last_relayed_ = info.sequence;
    const auto sent_ns = static_cast<std::uint64_t>(info.source_time.nanoseconds());
    if (published_.get() == 0) first_ns_.set(sent_ns);
    last_ns_.set(sent_ns);
    published_.add();
  }
  if (bytes_copied != 0) {
    copies_.add();
    bytes_copied_.add(bytes_copied);
  }
  update_routes(block);
  chosen_.clear();
  std::size_t owners = 0;
  for (const auto& reader : routes_) {
    const bool wanted =
        readers.empty() ? !reader->keeps_all() : std::ranges::find(readers, reader->id()) != readers.end();
    if (!wanted) continue;
    if (reader->wants_history() && reader->seen(id_) >= info.sequence) {
      if (reader->keeps_all()) broker_.links_.left(reader->id(), spec_.via);
      continue;
    }
    chosen_.push_back(reader.get());
    if (reader->taking() == Taking::Own) ++owners;
  }
  // As in distribute(): if there are non-owning readers, every owner gets a copy; with owners only, the last one gets
  // the original.
  const std::size_t sharers = chosen_.size() - owners;
  if (sharers != 0) block.references.fetch_add(static_cast<std::uint32_t>(sharers), std::memory_order_relaxed);
  bool given = false;
  for (ReaderQueue* const reader : chosen_) {
    if (reader->taking() == Taking::Share) continue;
    given = --owners == 0 && sharers == 0;
    if (given) {
      pass_on(*reader, block);
      break;
    }
    Block& copy = *copy_of(block, *pool_);  // a proxy's pool has no limit
    copy.via = spec_.via;
    pass_on(*reader, copy);
  }
  for (ReaderQueue* const reader : chosen_) {
    if (reader->taking() == Taking::Share) pass_on(*reader, block);
  }
  if (!given) drop_reference(block);
}

}  // namespace nacelle::runtime
