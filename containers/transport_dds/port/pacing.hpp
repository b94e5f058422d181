// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "transport_dds/port/cyclone.hpp"

namespace nacelle::transport_dds {

/// Messages of at least this size are paced.
inline constexpr std::size_t kPacedFrom = std::size_t{16} << 10U;

/// Paces the writes of the calling thread while this object exists, so that other writers can send in between.
///
/// Cyclone sends a message as one burst of datagrams through the socket that all writers share. On a slow link the
/// datagrams queue in the kernel, and the next messages wait behind them: 7 s behind an image of 0.9 MB at 1 Mbit/s. So
/// after each datagram the thread waits until the kernel has sent most of its queue. A small message then waits for two
/// or three datagrams, and never for room in the socket.
/// Threads: the one that made it; one object per thread at a time.
class Pacing {
 public:
  /// `type` is the message's, and determines the domain with its sockets. Null: nothing is paced.
  explicit Pacing(const ddsi_sertype* type) noexcept;
  Pacing(const Pacing&) = delete;
  Pacing& operator=(const Pacing&) = delete;
  ~Pacing();

  /// Called after this thread has sent a datagram, with none of Cyclone's locks held except the writer's.
  static void after_datagram() noexcept;

 private:
  ddsi_domaingv* domain_;
};

}  // namespace nacelle::transport_dds
