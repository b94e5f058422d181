// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iceoryx_posh/popo/listener.hpp>
#include <iceoryx_posh/popo/untyped_publisher.hpp>
#include <iceoryx_posh/popo/untyped_subscriber.hpp>
#include <iceoryx_posh/runtime/posh_runtime.hpp>
#include <string>

#include "between/ends.hpp"

namespace nacelle::bench {
namespace {

iox::capro::ServiceDescription service(std::uint32_t bytes) {
  return {"bench", "bare", iox::capro::IdString_t(iox::cxx::TruncateToCapacity, std::to_string(bytes).c_str())};
}

class BareSender final : public SendingEnd {
 public:
  explicit BareSender(std::uint32_t bytes) : bytes_(bytes), publisher_(service(bytes)) {}
  bool is_connected() const override { return publisher_.hasSubscribers(); }
  void send(std::uint8_t seed) override {
    auto chunk = publisher_.loan(bytes_, 64);
    if (chunk.has_error()) std::fputs("between: iceoryx lends no chunk\n", stderr), std::exit(1);
    std::memset(chunk.value(), seed, bytes_);
    publisher_.publish(chunk.value());
  }

 private:
  const std::uint32_t bytes_;
  iox::popo::UntypedPublisher publisher_;
};

class BareReceiver final : public ReceivingEnd {
 public:
  BareReceiver(std::uint32_t bytes, Arrivals& arrivals)
      : bytes_(bytes), arrivals_(arrivals), subscriber_(service(bytes)) {
    listener_
        .attachEvent(subscriber_, iox::popo::SubscriberEvent::DATA_RECEIVED,
                     iox::popo::createNotificationCallback(BareReceiver::take, *this))
        .or_else([](auto) { std::abort(); });
  }
  ~BareReceiver() override { listener_.detachEvent(subscriber_, iox::popo::SubscriberEvent::DATA_RECEIVED); }

 private:
  static void take(iox::popo::UntypedSubscriber* subscriber, BareReceiver* self) {
    while (true) {
      const auto chunk = subscriber->take();
      if (chunk.has_error()) return;
      const auto* const bytes = static_cast<const std::uint8_t*>(chunk.value());
      if (bytes[0] != bytes[self->bytes_ - 1]) std::abort();
      subscriber->release(chunk.value());
      self->arrivals_.add();
    }
  }

  const std::uint32_t bytes_;
  Arrivals& arrivals_;
  iox::popo::UntypedSubscriber subscriber_;
  iox::popo::Listener listener_;
};

}  // namespace

std::unique_ptr<SendingEnd> bare_sender(std::uint32_t bytes) { return std::make_unique<BareSender>(bytes); }
std::unique_ptr<ReceivingEnd> bare_receiver(std::uint32_t bytes, Arrivals& arrivals) {
  return std::make_unique<BareReceiver>(bytes, arrivals);
}

std::uint64_t bare_in_one_thread(std::uint32_t bytes, std::uint64_t messages) {
  BareSender sender(bytes);
  iox::popo::UntypedSubscriber subscriber(service(bytes));
  std::uint64_t arrived = 0;
  for (std::uint64_t i = 0; i < messages; ++i) {
    sender.send(static_cast<std::uint8_t>(i));
    const auto chunk = subscriber.take();
    if (chunk.has_error()) continue;
    ++arrived;
    subscriber.release(chunk.value());
  }
  return arrived;
}

}  // namespace nacelle::bench
