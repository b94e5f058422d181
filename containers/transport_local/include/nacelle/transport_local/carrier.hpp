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

/// The messages of one writer between two processes. Both ends of a link derive the same name for it.
struct CarriedStream {
  std::string name;                         ///< Unique on the host: sender, writer and topic.
  const msgs::MessageType* type = nullptr;  ///< Lives in the message package's library.
  std::size_t depth = 1;                    ///< Messages that may wait at the reader.
};

/// The sending end of a stream. Ownership: the link's; destroying it ends the stream.
/// Threads: one at a time, except where stated. Never blocks.
class CarrierWriter {
 public:
  virtual ~CarrierWriter() = default;
  enum class Sent : std::uint8_t {
    Yes,
    Refused,  ///< Too large, or no memory left: the link sends this message and all later ones over the socket.
    Dead,     ///< The carrier's daemon is gone: the link sends all streams over the socket from now on.
  };
  /// Sends a message and its info. Reads the block; the caller keeps its reference.
  [[nodiscard]] virtual Sent send(const Block& block) = 0;
  /// Returns true once the other end receives messages; until then the link uses the socket. Threads: any.
  [[nodiscard]] virtual bool is_connected() const = 0;
  /// Returns the number of payload bytes that send() has copied so far. Threads: any.
  [[nodiscard]] virtual std::uint64_t bytes_copied() const = 0;
  /// Gives the long Buffers of a message memory from which send() need not copy, if there is any. Call it for a
  /// borrowed message before the component fills it. Threads: the publisher's, also during a send() on the link's.
  virtual void prepare(Block& block) { static_cast<void>(block); }
};

/// Receives the messages of a stream. The link implements it with a proxy writer of the receiving process's broker.
/// Threads: the carrier's, and callers of CarrierReader::drain(); one call at a time. Must not throw or block.
class CarrierSink {
 public:
  virtual ~CarrierSink() = default;
  /// Returns an envelope to fill. Null: the carrier drops the message, which the sink has counted.
  [[nodiscard]] virtual Block* borrow() noexcept = 0;
  /// Delivers a message. Takes over the reference. `info` is stamped by the writer.
  virtual void deliver(Block& block, const MessageInfo& info) noexcept = 0;
  /// Reports received bytes that are not a message of the stream's type.
  virtual void note_broken(const char* why) noexcept = 0;
  /// Returns false if a reader may write into its message (Taking::Own), so that messages need memory of their own.
  /// Called for each message.
  [[nodiscard]] virtual bool may_lend() const noexcept { return true; }
};

/// The receiving end of a stream. After its destructor has returned, its sink is not called any more.
class CarrierReader {
 public:
  virtual ~CarrierReader() = default;
  /// Delivers all messages that have arrived before this call. The link calls it before it delivers a message of the
  /// stream that came over the socket, which keeps the order. Threads: any, but not from a call of the sink.
  virtual void drain() = 0;
};

/// Transfers the messages of single streams between processes of one host, faster than the link's socket does.
///
/// The link matches endpoints and applies QoS. A carrier transfers messages reliably and in order, without history. It
/// is optional: streams that it cannot carry use the socket. Threads: any.
class Carrier {
 public:
  virtual ~Carrier() = default;
  /// Returns the name of the kind of carrier, such as "iceoryx". Both ends of a link must use the same kind.
  [[nodiscard]] virtual const char* name() const = 0;
  /// Returns false from the loss of its daemon on, until this process is restarted.
  [[nodiscard]] virtual bool is_alive() const = 0;
  /// Returns null if it cannot carry this stream; the reason has been logged.
  [[nodiscard]] virtual std::unique_ptr<CarrierWriter> create_writer(const CarriedStream& stream) = 0;
  [[nodiscard]] virtual std::unique_ptr<CarrierReader> create_reader(const CarriedStream& stream,
                                                                     CarrierSink& sink) = 0;
};

}  // namespace nacelle
