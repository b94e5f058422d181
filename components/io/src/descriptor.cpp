// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/descriptor.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <system_error>

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

Bell::Bell() : event_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!event_.is_open()) throw std::system_error{errno, std::generic_category(), "no eventfd"};
}

void Bell::ring() noexcept {
  const std::uint64_t one = 1;
  // A full counter cannot happen (2^64 rings), and a bell that already rings needs no second ring.
  [[maybe_unused]] const auto written = ::write(event_.number(), &one, sizeof one);
}

bool Bell::silence() noexcept {
  std::uint64_t rings = 0;
  return ::read(event_.number(), &rings, sizeof rings) == static_cast<ssize_t>(sizeof rings);
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
