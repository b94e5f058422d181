// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "nacelle/host/transport.hpp"

namespace nacelle {

/// An endpoint as a link to another process announces it.
struct EndpointInfo {
  std::uint64_t id = 0;  ///< Unique on the host while its process lives; a writer's is the one that its messages carry.
  bool is_writer = false;
  bool open = true;   ///< A reader's lifecycle gate.
  EndpointSpec spec;  ///< Without the gate and the listener.
};

/// Told how a graph changes. Threads: any, with the graph's locks held: only note it and return.
class GraphListener {
 public:
  virtual ~GraphListener() = default;
  virtual void on_made(const EndpointInfo& endpoint) noexcept = 0;
  virtual void on_gone(std::uint64_t id) noexcept = 0;
  virtual void on_gate(std::uint64_t reader, bool open) noexcept = 0;
  /// A writer with liveliness manual_by_topic showed life, with or without a message.
  virtual void on_life(std::uint64_t writer) noexcept = 0;
  /// A message that this listener's link brought has left the queue of a KEEP_ALL reader: taken, dropped or refused.
  virtual void on_left(std::uint64_t reader) noexcept = 0;
};

/// Stands for a writer of another process. Threads: as Writer, relay() as publish().
class ProxyWriter : public Writer {
 public:
  /// Takes over the caller's reference. Hands the message on with the info that its writer stamped (but for the receive stamp),
  /// to these readers; to none: to all that match but KEEP_ALL ones. A reader that asks for history gets nothing twice.
  /// `bytes_copied`: what bringing it here has copied.
  virtual void relay(Block& block, const MessageInfo& info, MonotonicTime expires,
                     std::span<const std::uint64_t> readers, std::uint64_t bytes_copied) = 0;
};

/// Lends the long Buffers of a message memory from which sending it need not copy (Buffer::adopt), if it can.
/// Threads: the publisher's of that writer.
class BufferLender {
 public:
  virtual ~BufferLender() = default;
  virtual void prepare(std::uint64_t writer, Block& block) noexcept = 0;
};

/// Stands for a reader of another process. Threads: as Reader; look() and release() as take().
class ProxyReader : public Reader {
 public:
  /// The oldest message that has not been looked at, with a reference that is the caller's, or null. Unlike take(), it goes on
  /// filling its place until release() or the end of its lifespan: a KEEP_ALL queue holds what the other process has not taken.
  [[nodiscard]] virtual Block* look() = 0;
  /// The other process has got rid of so many more messages, in order.
  virtual void release(std::uint64_t messages) = 0;
  /// Opening the gate brings the whole history again, since the other side may have dropped what was sent.
  virtual void forget_seen() = 0;
  /// While this is its only reader, a writer asks for each message that is borrowed. To be set before messages come.
  virtual void set_lender(std::shared_ptr<BufferLender> lender) = 0;
  /// A message was copied on its way out; counted on the stream.
  virtual void note_copied(std::uint64_t bytes) = 0;
};

/// Stands for a reader of another process that gets its messages by taps. Threads: any.
class Witness {
 public:
  virtual ~Witness() = default;
  /// Whether it is one of this writer's subscriptions: from when what the writer publishes finds its way to the reader.
  virtual void count_for(std::uint64_t writer, bool counts) = 0;
};

/// A transport whose endpoints links to other processes can learn of, and add stand-ins to (docs/adr/0007).
/// Threads: any.
class Graph : public Transport {
 public:
  /// Tells the listener of all that is there, and from then on of each change. Returns the number of the link, for EndpointSpec::via.
  [[nodiscard]] virtual std::uint32_t join(GraphListener& listener) = 0;
  /// After its return the listener is not called any more.
  virtual void leave(std::uint32_t link) = 0;
  /// `spec.via` is the link's number; `id` the writer's own.
  [[nodiscard]] virtual std::unique_ptr<ProxyWriter> create_proxy_writer(const EndpointSpec& spec,
                                                                         std::uint64_t id) = 0;
  [[nodiscard]] virtual std::unique_ptr<ProxyReader> create_proxy_reader(const EndpointSpec& spec,
                                                                         ReadyListener* listener) = 0;
  /// Creates a reader of this one writer, history included, for a link that has an endpoint of its own for each writer.
  /// Its queue overwrites, so that it never delays a publisher. It is not a subscription: it is neither counted nor
  /// reported, except to the process that the writer itself represents. When the writer ends, it gets no more messages.
  [[nodiscard]] virtual std::unique_ptr<ProxyReader> create_tap(const EndpointInfo& writer, std::uint32_t link,
                                                                ReadyListener* listener) = 0;
  /// Creates a proxy for a reader that gets its messages by taps: its QoS is checked at once like the reader's, the
  /// writers that are assigned to it count it, and it never receives messages. Costs a publish() nothing.
  [[nodiscard]] virtual std::unique_ptr<Witness> create_witness(const EndpointSpec& spec) = 0;
  /// What a reader of this process has lost on the way to it: adds `overwritten`, `full`, `expired` and `inactive`.
  virtual void note_lost(const EndpointInfo& reader, const ReaderCounters& losses) = 0;
  /// An end of another process has another type, which this process need not know: counted and told to ours (the one with this
  /// id and topic) as a clash of types. `node`, `type`: the other's, for people. Each call counts.
  virtual void note_other_type(const EndpointInfo& ours, const std::string& node, const std::string& type) = 0;
};

}  // namespace nacelle
