// SPDX-License-Identifier: Apache-2.0
#include "range/component/vl53l0x_stream.hpp"

#include <algorithm>
#include <utility>

namespace nacelle::range {

Vl53l0xStream::Vl53l0xStream(std::unique_ptr<io::RegisterBus> bus, const Vl53l0x::Settings& settings,
                             const Clock& clock)
    : bus_(std::move(bus)),
      period_(settings.period),
      clock_(clock),
      device_(*bus_, settings, clock),
      next_(clock.now() + kLook) {}

Result<ByteView, io::StreamFault> Vl53l0xStream::read_until(MonotonicTime deadline) {
  if (is_away()) return err(io::StreamFault::NotFound);
  for (;;) {
    if (!bus_->wait_until(std::min(next_, deadline))) return ByteView{};
    const MonotonicTime now = clock_.now();
    if (now < next_) return ByteView{};
    const auto is_new = device_.read(record_);
    if (!is_new) return err(is_new.error());
    // The device's clock may be some percent fast.
    next_ = now + (*is_new ? std::max<Duration>(kLook, period_ * 7 / 8) : kLook);
    if (*is_new) return ByteView{record_};
    if (now >= deadline) return ByteView{};
  }
}

Result<void, io::StreamFault> Vl53l0xStream::reopen() {
  if (auto opened = bus_->reopen(); !opened) return opened;
  lost_ = false;
  next_ = clock_.now() + kLook;
  return {};
}

}  // namespace nacelle::range
