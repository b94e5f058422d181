// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "nacelle/host/message.hpp"
#include "nacelle/qos/announced.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::msgs {
struct MessageType;
}

namespace nacelle {

class DurationHistogram;

/// What publish() did with the message. The message is gone from the caller in every case.
enum class PublishResult : std::uint8_t {
  Published,   ///< Handed to every matched reader (perhaps none).
  Inactive,    ///< The lifecycle node is not active: dropped and counted.
  WouldBlock,  ///< A reliable KEEP_ALL reader is full: this reader did not get it, counted.
  PoolDry,     ///< The readers kept all messages that QoS::when_dry() allows: this one was dropped, counted.
};

/// Called when an endpoint's EndpointStatus has changed. Threads: any, with locks held: only record it and return.
class StatusListener {
 public:
  virtual ~StatusListener() = default;
  virtual void on_status() noexcept = 0;
};

/// How long a reader follows the last message when no other comes; then it stops what it moves (a base and its velocity command).
struct CommandTimeout {
  Duration after{};       ///< Zero: it has none.
  std::string parameter;  ///< Of the reader's node; sets it, in seconds.
};

/// One end of a stream as the graph sees it.
struct EndpointSpec {
  std::string topic;                        ///< Fully qualified name, e.g. "/camera/image_raw".
  const msgs::MessageType* type = nullptr;  ///< Lives in the message package's library.
  QoS qos{10};
  std::string node;  ///< Fully qualified node name, for reports; empty: a tool, left out of them.
  /// The lifecycle gate. While it holds false, a writer's publish() drops and counts; a reader starts as the gate is when it is
  /// made and follows set_enabled() from then on. Null is open.
  const std::atomic<bool>* gate = nullptr;
  StatusListener* status_listener = nullptr;  ///< Must outlive the endpoint. Null: none.
  bool tells_lost = false;                    ///< Whether the listener is called for each lost message.
  /// A writer with PoolPolicy::Fail ran dry: what a fault of its component says. Called on the publisher's thread.
  std::function<void(std::string code, std::string text)> on_fault;
  /// The link that made it as the stand-in for an endpoint of another process (graph.hpp); 0: an endpoint of this process.
  /// Stand-ins of one link do not match each other.
  std::uint32_t via = 0;
  /// Of a reader, for tools that publish: they say when they are too slow for it.
  CommandTimeout command_timeout{};
  /// Of a reader: it leaves writers that offer at least this to another reader of its node, so that nothing comes twice.
  std::optional<QoS> unless_offered{};
  Announced announced = Announced::Always;  ///< Of a reader.
  /// Of a writer: what the queues of its readers may hold is made before it is needed. Not for a deep queue that is empty as a rule.
  bool reserves = true;
};

/// DDS's communication statuses of an endpoint, as totals since its creation. For the change since an earlier status,
/// subtract that status.
struct EndpointStatus {
  /// Periods that passed without a message. The first message starts the clock (as in DDS, where an instance begins with it);
  /// a closed lifecycle gate stops it. A reader counts over all its writers.
  std::uint64_t deadline_missed = 0;
  std::uint64_t liveliness_lost = 0;    ///< Writer: leases that ran out (manual_by_topic only).
  std::uint32_t alive = 0;              ///< Reader: matched writers that show life ...
  std::uint32_t not_alive = 0;          ///< ... and those whose lease ran out.
  std::uint64_t lost = 0;               ///< Reader: messages that it will never get: overwritten, refused, expired.
  std::uint32_t matched = 0;            ///< Endpoints of the other side, now.
  std::uint64_t matched_total = 0;      ///< The same, ever.
  std::uint64_t incompatible_qos = 0;   ///< Endpoints of the other side whose QoS does not fit.
  std::uint64_t incompatible_type = 0;  ///< Endpoints of the other side with another type.
  std::string last_policy;              ///< Of the last incompatible one: "reliability", "type", ...
  std::string last_clash;               ///< Both ends, policy, both values and the change that mends it, in words.
};

/// Does a reader look at a shared message or take it for itself? The callback's signature decides (design D4).
enum class Taking : std::uint8_t { Share, Own };

struct WriterCounters {
  std::uint64_t published = 0;
  std::uint64_t inactive = 0;      ///< Dropped by the lifecycle gate.
  std::uint64_t would_block = 0;   ///< Refusals of full KEEP_ALL readers.
  std::uint64_t copies = 0;        ///< Messages copied in publish() for owners.
  std::uint64_t bytes_copied = 0;  ///< Encoded size of those copies.
  std::uint64_t pool_grown = 0;    ///< Envelopes made after the first ones: steady state adds none.
  std::uint64_t pool_dry = 0;      ///< Messages dropped because the pool was dry (PoolPolicy Drop and Fail).
};

struct ReaderCounters {
  std::uint64_t received = 0;     ///< Put into the queue.
  std::uint64_t delivered = 0;    ///< Taken out for the callback.
  std::uint64_t overwritten = 0;  ///< KEEP_LAST: the oldest made room.
  std::uint64_t full = 0;         ///< KEEP_ALL: no room left.
  std::uint64_t inactive = 0;     ///< Dropped by the lifecycle gate.
  std::uint64_t expired = 0;      ///< Older than the writer's lifespan when its turn came.
  std::uint64_t discarded = 0;    ///< Still waiting when the reader was closed.
  std::uint64_t rehomed = 0;      ///< Moved to the heap for a plain unique_ptr.
};

/// The sending end. Ownership: the publisher's; destroying it leaves the stream.
/// Threads: borrow(), adopt() and publish() belong to one thread at a time; const members from any thread.
class Writer {
 public:
  virtual ~Writer() = default;
  /// An envelope from this writer's pool, with one reference that is the caller's. When the pool is dry and must not grow it is
  /// one that publish() drops, and null for a caller who holds that one already.
  [[nodiscard]] virtual Block* borrow() = 0;
  /// An envelope around a message made with `new`; it is destroyed through its MessageType. Takes over `message`.
  [[nodiscard]] virtual Block* adopt(void* message) = 0;
  /// Takes over the caller's reference. Stamps the message and hands it to the matched readers. Where a reliable KEEP_ALL
  /// reader has no room it waits for at most the QoS's max_blocking_time, and never on an executor's thread.
  virtual PublishResult publish(Block& block) = 0;
  /// Shows life without a message; liveliness manual_by_topic asks for one or the other within the lease. Threads: any.
  virtual void assert_liveliness() = 0;
  [[nodiscard]] virtual std::size_t reader_count() const = 0;
  [[nodiscard]] virtual WriterCounters counters() const = 0;
  [[nodiscard]] virtual EndpointStatus status() const = 0;
  [[nodiscard]] virtual std::uint64_t id() const = 0;
};

/// Called when a reader has a message to take. Threads: called on the publisher's thread, one call at a time for each reader, and
/// not after the reader's destructor has returned; only note it and return. Whether it may call take() and has_waiting() of that
/// reader is for the transport to say: the Broker allows it. Nothing else of the transport may be called from within.
class ReadyListener {
 public:
  virtual ~ReadyListener() = default;
  virtual void on_ready() noexcept = 0;
};

/// The receiving end: a queue in the shape that the QoS asks for.
/// Threads: take() belongs to one thread at a time; the rest from any thread.
class Reader {
 public:
  virtual ~Reader() = default;
  /// The oldest waiting message with one reference that is the caller's (for Taking::Own: the only one), or null.
  [[nodiscard]] virtual Block* take() = 0;
  [[nodiscard]] virtual bool has_waiting() const = 0;
  [[nodiscard]] virtual std::size_t writer_count() const = 0;
  [[nodiscard]] virtual ReaderCounters counters() const = 0;
  [[nodiscard]] virtual EndpointStatus status() const = 0;
  /// The lifecycle gate. Closing it drops (and counts) what waits; opening it brings what the reader has missed of a
  /// transient_local history.
  virtual void set_enabled(bool enabled) = 0;
  /// Records the time since publish(). Called by the runner of the callback.
  virtual void note_latency(Duration latency) = 0;
  /// Returns the recorded latencies, or null if the transport keeps none. Threads: any.
  [[nodiscard]] virtual const DurationHistogram* latency() const { return nullptr; }
  virtual void note_rehomed() = 0;
};

/// A way for messages between endpoints with one QoS meaning (design D5): in process, between processes, on the network.
///
/// Every implementation passes test/conformance, the fake of test/support included. Endpoints that cannot be matched (QoS or
/// type) are made all the same and reported: the other pairs of the topic still work.
/// Threads: any. A listener given to create_reader() must outlive the reader.
class Transport {
 public:
  virtual ~Transport() = default;
  /// Never null.
  [[nodiscard]] virtual std::unique_ptr<Writer> create_writer(const EndpointSpec& spec) = 0;
  /// Never null. `listener` may be null for a reader that is polled.
  [[nodiscard]] virtual std::unique_ptr<Reader> create_reader(const EndpointSpec& spec, Taking taking,
                                                              ReadyListener* listener) = 0;
  /// Looks at what the passing of time has broken (deadlines, leases, lifespans) and at types that clash, and tells the status
  /// listeners. Returns when to look again at the latest; an earlier look does no harm. Threads: any.
  virtual MonotonicTime watch(MonotonicTime now) = 0;
};

}  // namespace nacelle
