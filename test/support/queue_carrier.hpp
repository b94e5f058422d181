// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/transport_local/carrier.hpp"

namespace nacelle::test {

/// A carrier within a process: a sent message waits in its stream's queue until the test drains the reader, so that the test decides
/// when it arrives. Both links use the same carrier. Threads: one.
class QueueCarrier final : public Carrier {
 public:
  bool refuses_readers = false, refuses_messages = false, alive = true, connected = true;
  std::size_t sent = 0;

  const char* name() const override { return "queue"; }
  bool is_alive() const override { return alive; }
  std::unique_ptr<CarrierWriter> create_writer(const CarriedStream& stream) override {
    return std::make_unique<WriterEnd>(*this, stream);
  }
  std::unique_ptr<CarrierReader> create_reader(const CarriedStream& stream, CarrierSink& sink) override {
    if (refuses_readers) return nullptr;
    return std::make_unique<ReaderEnd>(*this, stream, sink);
  }
  /// Everything that waits arrives.
  void bring() {
    for (auto& [stream, reader] : readers_) reader->drain();
  }

 private:
  struct Waiting {
    MessageInfo info;
    Bytes cdr;
  };
  struct WriterEnd final : CarrierWriter {
    WriterEnd(QueueCarrier& in, CarriedStream of) : carrier(in), stream(std::move(of)) {}
    Sent send(const Block& block) override {
      if (!carrier.alive) return Sent::Dead;
      if (carrier.refuses_messages) return Sent::Refused;
      Waiting waiting{block.info, Bytes(stream.type->encoded_size(block.message))};
      stream.type->encode(block.message, waiting.cdr.data());
      carrier.queues_[stream.name].push_back(std::move(waiting));
      ++carrier.sent;
      return Sent::Yes;
    }
    bool is_connected() const override { return carrier.connected && carrier.readers_.contains(stream.name); }
    std::uint64_t bytes_copied() const override { return 0; }
    QueueCarrier& carrier;
    const CarriedStream stream;
  };
  struct ReaderEnd final : CarrierReader {
    ReaderEnd(QueueCarrier& in, CarriedStream of, CarrierSink& to) : carrier(in), stream(std::move(of)), sink(to) {
      carrier.readers_[stream.name] = this;
    }
    ~ReaderEnd() override { carrier.readers_.erase(stream.name); }
    void drain() override {
      auto& queue = carrier.queues_[stream.name];
      for (; !queue.empty(); queue.pop_front()) {
        Block* const block = sink.borrow();
        if (block == nullptr) continue;
        if (stream.type->decode(queue.front().cdr, block->message)) {
          sink.deliver(*block, queue.front().info);
        } else {
          drop_reference(*block);
          sink.note_broken("it does not decode");
        }
      }
    }
    QueueCarrier& carrier;
    const CarriedStream stream;
    CarrierSink& sink;
  };

  std::map<std::string, std::deque<Waiting>> queues_;
  std::map<std::string, ReaderEnd*> readers_;
};

}  // namespace nacelle::test
