// SPDX-License-Identifier: Apache-2.0
#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "daemon.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "reader.hpp"
#include "reading_thread.hpp"
#include "transport_iceoryx/wire/stream_name.hpp"
#include "writer.hpp"

namespace nacelle::transport_iceoryx {
namespace {

constexpr std::size_t kMostDepth = iox::build::IOX_MAX_CHUNKS_HELD_PER_SUBSCRIBER_SIMULTANEOUSLY;
// iceoryx lets a reader hold 256 chunks. One is taken while the held ones are counted. A component that hoards messages
// must not drain the daemon's pool: messages beyond the queue's depth and a few in callbacks are copied.
constexpr std::size_t kMostHeld = 240, kHeldBeyondDepth = 8;

iox::capro::IdString_t id(std::string_view text) {
  return iox::capro::IdString_t(iox::cxx::TruncateToCapacity, short_name(text).c_str());
}

// The wire form is part of the name: processes of two releases do not meet.
iox::capro::ServiceDescription service_of(const CarriedStream& stream) {
  return {id(std::string("nacelle/1/") + stream.type->name), id(stream.type->hash), id(stream.name)};
}

Logger logger() { return Logger("transport_iceoryx"); }

}  // namespace

class IceoryxCarrier::Impl {
 public:
  explicit Impl(Daemon& daemon) : daemon_(daemon) {}

  Daemon& daemon_;
  ReadingTotals totals_;
  Mutex mutex_;
  std::shared_ptr<ReadingThread> thread_ NACELLE_GUARDED_BY(mutex_);  // made with the first reader
};

namespace {

class Reader final : public CarrierReader {
 public:
  Reader(std::shared_ptr<StreamReader> stream, std::shared_ptr<ReadingThread> thread, std::size_t place)
      : stream_(std::move(stream)), thread_(std::move(thread)), place_(place) {}
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() override {
    thread_->remove(place_);
    stream_->close();
  }
  void drain() override { stream_->deliver(); }

 private:
  std::shared_ptr<StreamReader> stream_;
  std::shared_ptr<ReadingThread> thread_;
  std::size_t place_;
};

}  // namespace

IceoryxCarrier::IceoryxCarrier(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
IceoryxCarrier::~IceoryxCarrier() = default;

Result<std::unique_ptr<IceoryxCarrier>, Problem> IceoryxCarrier::start(Duration patience) {
  auto daemon = Daemon::connect(patience);
  if (!daemon) return err(daemon.error());
  return std::unique_ptr<IceoryxCarrier>(new IceoryxCarrier(std::make_unique<Impl>(**daemon)));
}

bool IceoryxCarrier::is_alive() const { return impl_->daemon_.is_alive(); }

std::unique_ptr<CarrierWriter> IceoryxCarrier::create_writer(const CarriedStream& stream) {
  if (!is_alive()) return nullptr;  // that was logged before
  const Daemon::Made made = impl_->daemon_.make_writer(service_of(stream));
  if (made.port == nullptr) {
    logger().warn("{}: no writer in shared memory: {}", stream.name, made.why);
    return nullptr;
  }
  auto* const port = new WriterPort(*static_cast<iox::popo::PublisherPortData*>(made.port));
  return std::make_unique<StreamWriter>(*port, impl_->daemon_, stream);
}

std::unique_ptr<CarrierReader> IceoryxCarrier::create_reader(const CarriedStream& stream, CarrierSink& sink) {
  if (!is_alive()) return nullptr;
  const auto refuse = [&stream](const std::string& why) {
    logger().warn("{}: no reader in shared memory: {}", stream.name, why);
    return nullptr;
  };
  if (stream.depth > kMostDepth) {
    return refuse("iceoryx keeps " + std::to_string(kMostDepth) + " messages at most, and " +
                  std::to_string(stream.depth) + " are asked for");
  }
  const LockGuard lock(impl_->mutex_);
  if (!impl_->thread_) {
    const Daemon::Made condition = impl_->daemon_.make_condition();
    if (condition.port == nullptr) return refuse(condition.why);
    impl_->thread_ = std::make_shared<ReadingThread>(*static_cast<iox::popo::ConditionVariableData*>(condition.port));
  }
  const std::size_t depth = std::max<std::size_t>(stream.depth, 1);
  const Daemon::Made made = impl_->daemon_.make_reader(service_of(stream), depth);
  if (made.port == nullptr) return refuse(made.why);
  auto* const port = new ReaderPort(*static_cast<iox::popo::SubscriberPortData*>(made.port),
                                    std::min(depth + kHeldBeyondDepth, kMostHeld));
  auto reader = std::make_shared<StreamReader>(*port, *stream.type, sink, impl_->totals_);
  const auto place = impl_->thread_->add(reader);
  if (!place) return refuse("a process has " + std::to_string(ReadingThread::kMostReaders) + " of them at most");
  port->notify(impl_->thread_->condition(), *place);
  // Messages from before the listener was set.
  reader->deliver();
  return std::make_unique<Reader>(std::move(reader), impl_->thread_, *place);
}

ReadingCounters IceoryxCarrier::reading() const {
  const auto get = [](const std::atomic<std::uint64_t>& count) { return count.load(std::memory_order_relaxed); };
  const ReadingTotals& totals = impl_->totals_;
  return {get(totals.lent), get(totals.bytes_copied), get(totals.broken), get(totals.overruns)};
}

}  // namespace nacelle::transport_iceoryx
