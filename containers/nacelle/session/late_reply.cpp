// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/late_reply.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

namespace nacelle::session {

Bell::Bell() : event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
Bell::~Bell() { ::close(event_); }

void Bell::ring() noexcept {
  const std::uint64_t one = 1;
  static_cast<void>(!::write(event_, &one, sizeof one));
}

}  // namespace nacelle::session
