// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "nacelle/base/mutex.hpp"
#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"
#include "reader_port.hpp"
#include "transport_iceoryx/wire/chunk.hpp"

namespace nacelle::transport_iceoryx {

/// Totals of all readers of a carrier: see ReadingCounters. Threads: any.
struct ReadingTotals {
  std::atomic<std::uint64_t> lent{0}, bytes_copied{0}, broken{0}, overruns{0};
};

/// Decodes the chunks of one stream into messages, and passes them to its sink.
/// Threads: any; concurrent calls of deliver() run one after the other. After close() has returned, the sink is not
/// called any more.
class StreamReader {
 public:
  StreamReader(ReaderPort& port, const msgs::MessageType& type, CarrierSink& sink, ReadingTotals& totals)
      : port_(port), type_(type), sink_(sink), totals_(totals) {}
  StreamReader(const StreamReader&) = delete;
  StreamReader& operator=(const StreamReader&) = delete;
  ~StreamReader() { close(); }

  /// Delivers all messages that have arrived.
  void deliver();
  void close();

 private:
  void deliver(ReaderPort::Chunk& chunk);
  /// Decodes a chunk. The chunk is given back at once, or with the release of a message that reads it in place.
  void read(const ChunkView& view, ReaderPort::Chunk& chunk, const std::uint8_t* bytes);
  void note_broken(const char* why);

  Mutex mutex_;  // one thread delivers at a time, which keeps the order
  bool closed_ NACELLE_GUARDED_BY(mutex_) = false;
  ReaderPort& port_;
  const msgs::MessageType& type_;
  CarrierSink& sink_;
  ReadingTotals& totals_;
};

}  // namespace nacelle::transport_iceoryx
