// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/descriptor.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>

namespace nacelle::io {
namespace {

timespec until(const Clock& clock, MonotonicTime deadline) {
  // A far deadline is cut to an hour: the callers loop, and the kernel refuses absurd values.
  const Duration left = std::clamp<Duration>(deadline - clock.now(), Duration::zero(), std::chrono::hours{1});
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
  timespec t{};
  t.tv_sec = static_cast<time_t>(seconds.count());
  t.tv_nsec = static_cast<long>((left - seconds).count());
  return t;
}

}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  if (this != &other) {
    if (number_ >= 0) ::close(number_);
    number_ = std::exchange(other.number_, -1);
  }
  return *this;
}

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

Wake wait_readable(int descriptor, Bell& bell, const Clock& clock, MonotonicTime deadline) {
  for (;;) {
    std::array<pollfd, 2> watched{pollfd{descriptor, POLLIN, 0}, pollfd{bell.descriptor(), POLLIN, 0}};
    const timespec left = until(clock, deadline);
    const int count = ::ppoll(watched.data(), watched.size(), &left, nullptr);
    if (count < 0 && errno != EINTR) return Wake::HungUp;
    if (count > 0) {
      if ((watched[1].revents & POLLIN) != 0 && bell.silence()) return Wake::Woken;
      if ((watched[0].revents & POLLIN) != 0) return Wake::Ready;
      if ((watched[0].revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return Wake::HungUp;
    }
    if (clock.now() >= deadline) return Wake::TimedOut;
  }
}

Wake wait_writable(int descriptor, const Clock& clock, MonotonicTime deadline) {
  for (;;) {
    pollfd watched{descriptor, POLLOUT, 0};
    const timespec left = until(clock, deadline);
    const int count = ::ppoll(&watched, 1, &left, nullptr);
    if (count < 0 && errno != EINTR) return Wake::HungUp;
    if (count > 0) {
      if ((watched.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) return Wake::HungUp;
      if ((watched.revents & POLLOUT) != 0) return Wake::Ready;
    }
    if (clock.now() >= deadline) return Wake::TimedOut;
  }
}

}  // namespace nacelle::io
