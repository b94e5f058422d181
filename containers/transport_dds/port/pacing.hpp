// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "transport_dds/port/cyclone.hpp"

namespace nacelle::transport_dds {

/// Messages from this size on are paced: more than one of Cyclone's datagrams.
inline constexpr std::size_t kPacedFrom = std::size_t{16} << 10U;

/// While it lives, what the calling thread writes leaves room on the wire for what others write.
///
/// Cyclone sends a message as one burst of datagrams through the socket that all writers share. Where the wire is slower,
/// they wait in the kernel, and whatever is sent next waits behind them: 7 s behind an image of 0.9 MB at 1 Mbit/s. So
/// after each datagram the thread waits until the kernel has got rid of most of what was sent. A small message
/// then waits for two or three datagrams, and never for room.
/// Threads: the one that made it, and one at a time there.
class Pacing {
 public:
  /// `type`: of the message; knows the sockets. Null: nothing is paced.
  explicit Pacing(const ddsi_sertype* type) noexcept;
  Pacing(const Pacing&) = delete;
  Pacing& operator=(const Pacing&) = delete;
  ~Pacing();

  /// A datagram of this thread's has been sent, and none of Cyclone's locks is held but the writer's own for its calls.
  static void after_datagram() noexcept;

 private:
  ddsi_domaingv* domain_;
};

}  // namespace nacelle::transport_dds
