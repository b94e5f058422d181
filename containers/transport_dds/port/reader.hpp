// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "nacelle/base/time.hpp"
#include "transport_dds/port/endpoint.hpp"
#include "transport_dds/port/participant.hpp"
#include "transport_dds/port/payload.hpp"

namespace nacelle::transport_dds {

/// A received message. Its bytes are hostile: check them.
struct Sample {
  Payload payload;
  WallTime source_time;             ///< By the writer's clock.
  Gid writer;                       ///< All zero if it had ended before it could be determined.
  std::uint64_t writer_handle = 0;  ///< Cyclone's number for it in this process: MatchedPeer::handle.
};

struct ReaderCounters {
  std::uint64_t received = 0;  ///< Put into the queue.
  std::uint64_t taken = 0;
  std::uint64_t overwritten = 0;  ///< KEEP_LAST: the oldest were dropped.
  std::uint64_t full = 0;         ///< KEEP_ALL: no room left.
  std::uint64_t refused = 0;      ///< Of this type, all readers: too large, or too many bytes held already.
};

/// Receives messages as bytes. Ownership: its creator; destroying it leaves the topic.
///
/// Cyclone's receiving thread puts messages into a queue that overwrites (KEEP_LAST) or drops when full (KEEP_ALL), and
/// calls the listener. It never waits for the thread that calls take().
/// Threads: take() one at a time; const members from any thread.
class Reader {
 public:
  /// Used by Participant::create_reader().
  [[nodiscard]] static Result<std::unique_ptr<Reader>, Problem> create(std::shared_ptr<ParticipantCore> core,
                                                                       const EndpointOptions& options,
                                                                       EndpointListener* listener);
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader();

  /// Takes the oldest waiting message. Allocates: for a writer seen for the first time.
  [[nodiscard]] std::optional<Sample> take();
  [[nodiscard]] bool has_waiting() const;
  [[nodiscard]] std::uint32_t matched_count() const;
  [[nodiscard]] Gid gid() const;
  [[nodiscard]] ReaderStatus status() const;
  [[nodiscard]] ReaderCounters counters() const;
  /// Returns the matched writers, with user data. Allocates: yes; do not call per message.
  [[nodiscard]] std::vector<MatchedPeer> matched() const;

 private:
  struct Impl;
  explicit Reader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle::transport_dds
