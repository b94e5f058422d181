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
  std::uint64_t refused = 0;  ///< borrow() had none to give: too many out, too large, no memory.
  std::uint64_t failed = 0;   ///< write() did not answer Yes.
};

/// Sends messages that are encoded already. Ownership: its maker's; destroying it leaves the topic.
/// Threads: const members from any thread; borrow() and write() from one at a time.
class Writer {
 public:
  /// Null listener: nobody is told. Used by Participant::create_writer().
  [[nodiscard]] static Result<std::unique_ptr<Writer>, Problem> create(std::shared_ptr<ParticipantCore> core,
                                                                       const EndpointOptions& options,
                                                                       EndpointListener* listener);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer();

  /// Readers that are matched: one load, so that nothing is encoded for nobody. It may be late by the time that a
  /// listener takes.
  [[nodiscard]] std::uint32_t matched_count() const { return matched_.load(std::memory_order_relaxed); }

  /// Memory for a message of so many bytes, encapsulation header included; false: refused, and counted.
  [[nodiscard]] OutgoingPayload borrow(std::size_t bytes);
  enum class Sent : std::uint8_t {
    Yes,      ///< It is in the history and on its way.
    Refused,  ///< A matched reader is too slow, and max_blocking has passed.
    Failed,   ///< No CDR (its first bytes say so), or Cyclone does not take it.
  };
  /// Sends it to all that are matched and keeps it as the QoS says. Nothing is copied, but into packets. Waits for room
  /// in the socket, a long message (pacing.hpp) for as long as the wire needs, and with KEEP_ALL for max_blocking at most:
  /// not for a publisher's thread. Meanwhile matched() and the destructor wait too; so does the end of any endpoint of
  /// the participant.
  Sent write(OutgoingPayload payload, WallTime source_time);

  /// Shows life without a message (liveliness manual_by_topic).
  void assert_liveliness();
  /// True if all that was written has been acknowledged by all reliable readers within the limit.
  [[nodiscard]] bool wait_for_acknowledgements(Duration limit);

  [[nodiscard]] Gid gid() const;
  /// Cyclone's own number of this writer: what rmw_cyclonedds writes into a request as the client's id.
  [[nodiscard]] std::uint64_t handle() const;
  [[nodiscard]] WriterStatus status() const;
  [[nodiscard]] WriterCounters counters() const;
  /// Payloads that are out: in the history, or on their way.
  [[nodiscard]] std::uint32_t out_count() const;
  /// Who is matched now, with user data. Allocates: yes; not per message.
  [[nodiscard]] std::vector<MatchedPeer> matched() const;

 private:
  struct Impl;
  explicit Writer(std::unique_ptr<Impl> impl);
  std::atomic<std::uint32_t> matched_{0};
  std::unique_ptr<Impl> impl_;  // the last member: its listeners touch what is above
};

}  // namespace nacelle::transport_dds
