// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "nacelle/base/mutex.hpp"
#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"
#include "reader_port.hpp"
#include "transport_iceoryx/wire/chunk.hpp"

namespace nacelle::transport_iceoryx {

/// What all readers of a carrier have done. Threads: any.
struct ReadingTotals {
  std::atomic<std::uint64_t> lent{0}, bytes_copied{0}, broken{0}, overruns{0};
};

/// Turns the chunks of one stream into messages for its sink.
/// Threads: deliver() from any; one at a time goes on, and none after close() has returned.
class StreamReader {
 public:
  StreamReader(ReaderPort& port, const msgs::MessageType& type, CarrierSink& sink, ReadingTotals& totals)
      : port_(port), type_(type), sink_(sink), totals_(totals) {}
  StreamReader(const StreamReader&) = delete;
  StreamReader& operator=(const StreamReader&) = delete;
  ~StreamReader() { close(); }

  /// Everything that has arrived.
  void deliver();
  void close();

 private:
  void deliver(ReaderPort::Chunk& chunk);
  /// Gives the chunk back, or lets the message keep it.
  void read(const ChunkView& view, ReaderPort::Chunk& chunk, const std::uint8_t* bytes);
  void note_broken(const char* why);

  Mutex mutex_;  // keeps the order: one thread delivers
  bool closed_ NACELLE_GUARDED_BY(mutex_) = false;
  ReaderPort& port_;
  const msgs::MessageType& type_;
  CarrierSink& sink_;
  ReadingTotals& totals_;
};

}  // namespace nacelle::transport_iceoryx
