// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "nacelle/base/bytes.hpp"
#include "transport_dds/wire/dds_qos.hpp"
#include "transport_dds/wire/discovered.hpp"

namespace nacelle::transport_dds {

/// A writer or reader to be made, in DDS's words.
struct EndpointOptions {
  std::string topic;      ///< "rt/chatter"
  std::string type;       ///< "std_msgs::msg::dds_::String_"
  std::string structure;  ///< What tells two types of one name apart: the type's hash.
  DdsQos qos;
  Bytes user_data;
  /// Writer: payloads that may be out at once (borrowed, or not acknowledged yet); 0: as many as the history keeps. For
  /// KEEP_ALL, whose history has no end.
  std::uint32_t most_out = 0;
  /// Reader with KEEP_ALL: messages that may wait to be taken.
  std::size_t most_waiting = 1000;
  /// Reader with KEEP_LAST: so many wait to be taken, if that is more than the history announces.
  std::size_t least_depth = 0;
};

/// An endpoint of the other side that is matched now.
struct MatchedPeer {
  DiscoveredEndpoint endpoint;
  std::uint64_t handle = 0;  ///< Cyclone's number for it in this process, as in Sample::writer_handle.
};

/// Totals since the writer was made.
struct WriterStatus {
  std::uint32_t matched = 0;  ///< Now.
  std::uint64_t matched_total = 0;
  std::uint64_t incompatible_qos = 0;          ///< Readers whose QoS does not fit ...
  DdsPolicy last_policy = DdsPolicy::Invalid;  ///< ... and why the last one's does not.
  std::uint64_t deadline_missed = 0;
  std::uint64_t liveliness_lost = 0;
};

/// Totals since the reader was made.
struct ReaderStatus {
  std::uint32_t matched = 0;  ///< Now.
  std::uint64_t matched_total = 0;
  std::uint64_t incompatible_qos = 0;
  DdsPolicy last_policy = DdsPolicy::Invalid;
  std::uint64_t deadline_missed = 0;
  std::uint32_t alive = 0, not_alive = 0;  ///< Matched writers that show life, and those that do not.
  std::uint64_t lost = 0;                  ///< Messages that never came: the writer no longer had them.
};

/// Called at events of an endpoint. Threads: Cyclone's (receiving, events), or that of a writer in this process; until
/// the endpoint's destructor has returned, and possibly before its create function has. Only note it and return: an
/// endpoint must not be made or ended from within.
class EndpointListener {
 public:
  virtual ~EndpointListener() = default;
  /// The status has changed.
  virtual void on_status() noexcept = 0;
  /// A reader has something to take. One call may stand for several messages.
  virtual void on_data() noexcept {}
};

}  // namespace nacelle::transport_dds
