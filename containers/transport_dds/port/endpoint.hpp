// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "nacelle/base/bytes.hpp"
#include "transport_dds/wire/dds_qos.hpp"
#include "transport_dds/wire/discovered.hpp"

namespace nacelle::transport_dds {

/// The options for making a writer or reader, with DDS's names.
struct EndpointOptions {
  std::string topic;      ///< "rt/chatter"
  std::string type;       ///< "std_msgs::msg::dds_::String_"
  std::string structure;  ///< Distinguishes two types of one name: the type's hash.
  DdsQos qos;
  Bytes user_data;
  /// Writer: the most payloads in use at the same time (borrowed, or not acknowledged yet); 0: no limit. For KEEP_ALL,
  /// whose history is unlimited.
  std::uint32_t most_out = 0;
  /// Reader with KEEP_ALL: the most messages that wait to be taken.
  std::size_t most_waiting = 1000;
  /// Reader with KEEP_LAST: the least capacity of its queue, if the announced history is shorter.
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
  std::uint64_t incompatible_qos = 0;          ///< Readers with incompatible QoS.
  DdsPolicy last_policy = DdsPolicy::Invalid;  ///< The incompatible policy of the last of them.
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
  std::uint32_t alive = 0, not_alive = 0;  ///< Matched writers by liveliness.
  std::uint64_t lost = 0;                  ///< Messages that were not received, because the writer no longer had them.
};

/// Called at events of an endpoint, possibly before its create function has returned, and until its destructor has. It
/// must only record the event: it must not make or destroy an endpoint.
/// Threads: Cyclone's (receiving, events), or the thread that writes in this process.
class EndpointListener {
 public:
  virtual ~EndpointListener() = default;
  /// Called when the status has changed.
  virtual void on_status() noexcept = 0;
  /// Called when a reader has messages to take. There may be one call for several messages.
  virtual void on_data() noexcept {}
};

}  // namespace nacelle::transport_dds
