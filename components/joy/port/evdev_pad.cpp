// SPDX-License-Identifier: Apache-2.0
#include "joy/port/evdev_pad.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace nacelle::joy {

EvdevPad::EvdevPad(PadWish wish, const Clock& clock, io::Descriptor device, std::string path, bool away)
    : wish_(std::move(wish)), clock_(clock), device_(std::move(device)), path_(std::move(path)), away_(away) {}

Result<std::unique_ptr<PadPort>, Problem> EvdevPad::open(const PadWish& wish, const Clock& clock) {
  auto found = find_pad(wish);
  if (!found) return err(found.error().problem);
  FoundPad pad = std::move(found).value();
  return std::unique_ptr<PadPort>{new EvdevPad{wish, clock, std::move(pad.device), pad.info.path, false}};
}

Result<std::unique_ptr<PadPort>, Problem> EvdevPad::open_or_await(const PadWish& wish, const Clock& clock) {
  auto found = find_pad(wish);
  if (found) {
    FoundPad pad = std::move(found).value();
    return std::unique_ptr<PadPort>{new EvdevPad{wish, clock, std::move(pad.device), pad.info.path, false}};
  }
  io::Descriptor reserved{found.error().fault == io::StreamFault::NotFound ? ::open("/dev/null", O_RDONLY | O_CLOEXEC)
                                                                           : -1};
  if (!reserved.is_open()) return err(found.error().problem);
  return std::unique_ptr<PadPort>{new EvdevPad{wish, clock, std::move(reserved), {}, true}};
}

Result<PadInfo, io::StreamFault> EvdevPad::inspect() {
  if (is_away()) return err(io::StreamFault::NotFound);
  auto info = inspect_device(device_.number(), path_);
  if (!info) return err(io::StreamFault::HungUp);
  return std::move(*info);
}

Result<ByteView, io::StreamFault> EvdevPad::read_until(MonotonicTime deadline) {
  if (is_away()) return err(io::StreamFault::NotFound);
  for (;;) {
    switch (io::wait_readable(device_.number(), bell_, clock_, deadline)) {
      case io::Wake::TimedOut:
      case io::Wake::Woken: return ByteView{};
      case io::Wake::HungUp: return err(io::StreamFault::HungUp);
      case io::Wake::Ready: break;
    }
    const ssize_t count = ::read(device_.number(), buffer_.data(), buffer_.size());
    if (count > 0) return ByteView{buffer_.data(), static_cast<std::size_t>(count)};
    if (count == 0 || errno == ENODEV || errno == ENXIO || errno == EIO) return err(io::StreamFault::HungUp);
    if (errno != EAGAIN && errno != EINTR) return err(io::StreamFault::ReadFailed);
  }
}

Result<void, io::StreamFault> EvdevPad::reopen() {
  auto found = find_pad(wish_);
  if (!found) return err(found.error().fault);
  FoundPad pad = std::move(found).value();
  if (::dup3(pad.device.number(), device_.number(), O_CLOEXEC) < 0) return err(io::StreamFault::NotUsable);
  path_ = std::move(pad.info.path);
  away_ = false;
  return {};
}

}  // namespace nacelle::joy
