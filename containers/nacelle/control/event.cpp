// SPDX-License-Identifier: Apache-2.0
#include "nacelle/control/event.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace nacelle::control {
namespace {

int open_event() {
  const int descriptor = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (descriptor < 0) throw std::system_error{errno, std::generic_category(), "no eventfd"};
  return descriptor;
}

}  // namespace

Event::Event() : descriptor_(open_event()) {}
Event::~Event() { ::close(descriptor_); }

void Event::set() noexcept {
  const std::uint64_t one = 1;
  // It can only fail when the counter is full, and then the other side has been woken already.
  static_cast<void>(!::write(descriptor_, &one, sizeof one));
}

void Event::clear() noexcept {
  std::uint64_t count = 0;
  static_cast<void>(!::read(descriptor_, &count, sizeof count));
}

}  // namespace nacelle::control
