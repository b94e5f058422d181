// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "nacelle/base/time.hpp"
#include "transport_dds/port/endpoint.hpp"
#include "transport_dds/port/participant.hpp"
#include "transport_dds/port/payload.hpp"

namespace nacelle::transport_dds {

struct WriterCounters {
  std::uint64_t written = 0;
  std::uint64_t refused = 0;  ///< borrow() failed: too many in use, too large, no memory.
  std::uint64_t failed = 0;   ///< write() did not return Sent::Yes.
};

/// Sends encoded messages. Ownership: its creator; destroying it leaves the topic.
/// Threads: const members from any thread; borrow() and write() from one at a time.
class Writer {
 public:
  /// The listener may be null. Used by Participant::create_writer().
  [[nodiscard]] static Result<std::unique_ptr<Writer>, Problem> create(std::shared_ptr<ParticipantCore> core,
                                                                       const EndpointOptions& options,
                                                                       EndpointListener* listener);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer();

  /// Returns the number of matched readers, with one load, so that nothing is encoded without a reader. It may lag by
  /// the duration of a listener call.
  [[nodiscard]] std::uint32_t matched_count() const { return matched_.load(std::memory_order_relaxed); }

  /// Returns memory for a message of that many bytes, including the encapsulation header; false if refused, which is
  /// counted.
  [[nodiscard]] OutgoingPayload borrow(std::size_t bytes);
  enum class Sent : std::uint8_t {
    Yes,      ///< The message is in the history and being sent.
    Refused,  ///< A matched reader was too slow, and max_blocking has passed.
    Failed,   ///< The message is not CDR (by its first bytes), or Cyclone refused it.
  };
  /// Sends a message to all matched readers and keeps it according to the QoS. Copies it only into packets. Waits for
  /// room in the socket, for a long message (pacing.hpp) as long as the link needs, and with KEEP_ALL for max_blocking
  /// at most, so do not call it on a publisher's thread. Meanwhile matched(), the destructor and the destruction of any
  /// endpoint of the participant wait too.
  Sent write(OutgoingPayload payload, WallTime source_time);

  /// Asserts liveliness without a message (manual_by_topic).
  void assert_liveliness();
  /// Returns true if all reliable readers have acknowledged all messages within the limit.
  [[nodiscard]] bool wait_for_acknowledgements(Duration limit);

  [[nodiscard]] Gid gid() const;
  /// Returns Cyclone's own number of this writer, which rmw_cyclonedds writes into a request as the client's id.
  [[nodiscard]] std::uint64_t handle() const;
  [[nodiscard]] WriterStatus status() const;
  [[nodiscard]] WriterCounters counters() const;
  /// Returns the number of payloads in use: in the history, or being sent.
  [[nodiscard]] std::uint32_t out_count() const;
  /// Returns the matched readers, with user data. Allocates: yes; do not call per message.
  [[nodiscard]] std::vector<MatchedPeer> matched() const;

 private:
  struct Impl;
  explicit Writer(std::unique_ptr<Impl> impl);
  std::atomic<std::uint32_t> matched_{0};
  std::unique_ptr<Impl> impl_;  // the last member: its listeners use the members above
};

}  // namespace nacelle::transport_dds
