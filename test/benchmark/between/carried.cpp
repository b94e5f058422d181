// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nacelle_bench_msgs/msg/stamped9_float32.hpp>
#include <nacelle_bench_msgs/msg/stamped_bytes.hpp>
#include <string>

#include "between/ends.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/runtime/pool.hpp"
#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"

namespace nacelle::bench {
namespace {

using Small = nacelle_bench_msgs::msg::Stamped9Float32;
using Large = nacelle_bench_msgs::msg::StampedBytes;
using transport_iceoryx::IceoryxCarrier;

constexpr std::uint32_t kSmallBytes = 44;

IceoryxCarrier& carrier() {
  static auto* const one = [] {
    auto started = IceoryxCarrier::start();
    if (!started) std::fprintf(stderr, "between: %s\n", started.error().text().c_str()), std::exit(1);
    return std::move(started).value().release();
  }();
  return *one;
}

const msgs::MessageType& type_of(std::uint32_t bytes) {
  return bytes == kSmallBytes ? Small::message_type() : Large::message_type();
}
CarriedStream stream_of(std::uint32_t bytes) { return {"/bench/" + std::to_string(bytes), &type_of(bytes), 8}; }

class CarriedSender final : public SendingEnd {
 public:
  CarriedSender(std::uint32_t bytes, bool prepared)
      : bytes_(bytes), prepared_(prepared), pool_(type_of(bytes)), writer_(carrier().create_writer(stream_of(bytes))) {
    if (!writer_) std::exit(1);
  }
  bool is_connected() const override { return writer_->is_connected(); }
  std::uint64_t bytes_copied() const override { return writer_->bytes_copied(); }
  void send(std::uint8_t seed) override {
    Block* const block = pool_.borrow();
    if (prepared_) writer_->prepare(*block);
    if (bytes_ == kSmallBytes) {
      auto& message = *static_cast<Small*>(block->message);
      message.stamp.sec = seed;
      message.values.fill(seed);
    } else {
      auto& message = *static_cast<Large*>(block->message);
      message.stamp.sec = seed;
      message.data.resize_uninitialized(bytes_);
      std::memset(message.data.data(), seed, bytes_);
    }
    block->info.sequence = ++sequence_;
    if (writer_->send(*block) != CarrierWriter::Sent::Yes) std::exit(1);
    drop_reference(*block);
  }

 private:
  const std::uint32_t bytes_;
  const bool prepared_;
  runtime::MessagePool pool_;
  std::unique_ptr<CarrierWriter> writer_;
  std::uint64_t sequence_ = 0;
};

class CarriedReceiver final : public ReceivingEnd, private CarrierSink {
 public:
  CarriedReceiver(std::uint32_t bytes, Arrivals& arrivals)
      : bytes_(bytes),
        arrivals_(arrivals),
        pool_(type_of(bytes)),
        reader_(carrier().create_reader(stream_of(bytes), *this)) {
    if (!reader_) std::exit(1);
  }
  std::uint64_t bytes_copied() const override { return carrier().reading().bytes_copied; }

 private:
  Block* borrow() noexcept override { return pool_.borrow(); }
  void deliver(Block& block, const MessageInfo&) noexcept override {
    if (bytes_ != kSmallBytes) {
      const auto& data = static_cast<const Large*>(block.message)->data;
      if (data.front() != data.back()) std::abort();
    } else if (const auto& values = static_cast<const Small*>(block.message)->values; values.front() != values.back()) {
      std::abort();
    }
    drop_reference(block);
    arrivals_.add();
  }
  void note_broken(const char* why) noexcept override { std::fprintf(stderr, "between: %s\n", why), std::abort(); }

  const std::uint32_t bytes_;
  Arrivals& arrivals_;
  runtime::MessagePool pool_;
  std::unique_ptr<CarrierReader> reader_;
};

}  // namespace

std::unique_ptr<SendingEnd> carried_sender(std::uint32_t bytes, bool prepared) {
  return std::make_unique<CarriedSender>(bytes, prepared);
}
std::unique_ptr<ReceivingEnd> carried_receiver(std::uint32_t bytes, Arrivals& arrivals) {
  return std::make_unique<CarriedReceiver>(bytes, arrivals);
}

}  // namespace nacelle::bench
