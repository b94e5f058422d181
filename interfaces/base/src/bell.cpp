// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/bell.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace nacelle {
namespace {

int open_event() {
  const int descriptor = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (descriptor < 0) throw std::system_error{errno, std::generic_category(), "no eventfd"};
  return descriptor;
}

}  // namespace

Bell::Bell() : descriptor_(open_event()) {}
Bell::~Bell() { ::close(descriptor_); }

void Bell::ring() noexcept {
  const std::uint64_t one = 1;
  // A full counter cannot happen (2^64 rings), and a bell that already rings needs no second ring.
  [[maybe_unused]] const auto written = ::write(descriptor_, &one, sizeof one);
}

bool Bell::silence() noexcept {
  std::uint64_t rings = 0;
  return ::read(descriptor_, &rings, sizeof rings) == static_cast<ssize_t>(sizeof rings);
}

}  // namespace nacelle
