// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "nacelle/host/message.hpp"

namespace nacelle::msgs {
struct MessageType;
}

namespace nacelle {

/// A stream between two processes as a carrier sees it. Both ends derive the same name from the same graph.
struct CarriedStream {
  std::string name;                         ///< Unique on the host: who sends, and the topic.
  const msgs::MessageType* type = nullptr;  ///< Lives in the message package's library.
  std::size_t depth = 1;                    ///< Messages that may wait at the reader.
};

/// The sending end. Ownership: the link's; destroying it ends the stream.
/// Threads: one at a time; never blocks, so that it may be the publisher's.
class CarrierWriter {
 public:
  virtual ~CarrierWriter() = default;
  enum class Sent : std::uint8_t {
    Yes,
    Refused,  ///< This message cannot go this way (too large, no memory left): the stream goes over the socket from now on.
    Dead,  ///< The carrier is gone (its daemon died): all streams go over the socket from now on.
  };
  /// Looks at the message and its info; the caller keeps its reference.
  [[nodiscard]] virtual Sent send(const Block& block) = 0;
  /// True once the other end would get what is sent; until then the link uses the socket.
  [[nodiscard]] virtual bool is_connected() const = 0;
  /// Payload bytes that send() had to copy so far. Threads: any.
  [[nodiscard]] virtual std::uint64_t bytes_copied() const = 0;
  /// Lends the message's long Buffers memory from which send() need not copy, if it can. Call it on what borrow() gave, before
  /// the component fills it. Threads: as send().
  virtual void prepare(Block& block) { static_cast<void>(block); }
};

/// Where arriving messages go. Implemented by the link, on top of a writer of the receiving process's broker.
/// Threads: the carrier's, one call at a time per stream. Must not throw or block.
class CarrierSink {
 public:
  virtual ~CarrierSink() = default;
  /// An envelope to fill; null: this message is dropped and counted.
  [[nodiscard]] virtual Block* borrow() noexcept = 0;
  /// Takes over the reference. `info` is what the writer stamped.
  virtual void deliver(Block& block, const MessageInfo& info) noexcept = 0;
  /// What came was no message of the stream's type.
  virtual void note_broken(const char* why) noexcept = 0;
  /// False: a reader may write into what it gets (Taking::Own), so messages must have memory of their own. Asked per message.
  [[nodiscard]] virtual bool may_lend() const noexcept { return true; }
};

/// The receiving end. Destroying it ends the calls of its sink.
class CarrierReader {
 public:
  virtual ~CarrierReader() = default;
  /// Delivers everything that has arrived before this call. The link calls it when a message of the stream comes over the
  /// socket, so that the change from one way to the other keeps the order. Threads: any but the sink's.
  virtual void drain() = 0;
};

/// A faster way than the link's socket for the messages of single streams, between processes of one host.
///
/// The link decides who talks to whom and what the QoS says; a carrier only moves messages: reliable, in order, without history.
/// Optional: what it cannot carry goes over the socket. Threads: any.
class Carrier {
 public:
  virtual ~Carrier() = default;
  /// Both ends must have the same, e.g. "iceoryx".
  [[nodiscard]] virtual const char* name() const = 0;
  /// False once its daemon is gone; it does not come back before the process restarts.
  [[nodiscard]] virtual bool is_alive() const = 0;
  /// Null: it cannot carry this stream; the reason has been logged.
  [[nodiscard]] virtual std::unique_ptr<CarrierWriter> create_writer(const CarriedStream& stream) = 0;
  [[nodiscard]] virtual std::unique_ptr<CarrierReader> create_reader(const CarriedStream& stream,
                                                                     CarrierSink& sink) = 0;
};

}  // namespace nacelle
