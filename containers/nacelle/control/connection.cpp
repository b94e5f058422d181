// SPDX-License-Identifier: Apache-2.0
#include "control/connection.hpp"

#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace nacelle::control {
namespace {

// Room for the live figures of a large robot, so that answering never grows it.
constexpr std::size_t kOutReserve = 64U << 10U;

}  // namespace

Connection::Connection(int descriptor) : descriptor_(descriptor) { out.reserve(kOutReserve); }
Connection::~Connection() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Connection::reuse_for(int descriptor) {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = descriptor;
  in.forget();
  out.clear();
  sent_ = 0;
}

bool Connection::read_some() {
  const ByteSpan room = in.room();
  const ssize_t got = ::recv(descriptor_, room.data(), room.size(), MSG_DONTWAIT);
  if (got > 0) {
    in.filled(static_cast<std::size_t>(got));
    return true;
  }
  return got < 0 && (errno == EAGAIN || errno == EINTR);
}

bool Connection::write_some() {
  while (wants_to_write()) {
    const ssize_t sent = ::send(descriptor_, out.data() + sent_, out.size() - sent_, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0) return errno == EAGAIN || errno == EINTR;
    sent_ += static_cast<std::size_t>(sent);
  }
  out.clear();  // keeps its capacity
  sent_ = 0;
  return true;
}

void Connection::say_farewell(std::string_view why) {
  append_frame(out, FrameKind::Fault, why);
  static_cast<void>(write_some());
}

std::size_t most_guests() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return 4;
  return static_cast<std::size_t>(std::clamp<rlim_t>(limit.rlim_cur / 8, 4, 64));
}

}  // namespace nacelle::control
