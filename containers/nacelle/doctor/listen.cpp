// SPDX-License-Identifier: Apache-2.0
#include "doctor/listen.hpp"

#include <algorithm>
#include <vector>

#include "nacelle/io/serial_port.hpp"

namespace nacelle::doctor {

Result<HeardDevice, Problem> listen(const std::string& path, const Clock& clock, Duration at_each) {
  std::vector<unsigned> bauds;
  for (const auto& device : io::known_serial_devices()) {
    if (std::find(bauds.begin(), bauds.end(), device.baud) == bauds.end()) bauds.push_back(device.baud);
  }
  HeardDevice heard;
  for (const unsigned baud : bauds) {
    auto port = io::SerialPort::open({path, baud}, clock);
    if (!port) return err(std::move(port).error());
    io::FirstBytes first;
    const MonotonicTime end = clock.now() + at_each;
    while (clock.now() < end) {
      const auto bytes = port.value()->read_until(end);
      if (!bytes) break;  // it was unplugged, or cannot be read: the next opening says so
      heard.bytes += bytes->size();
      first.add(*bytes);
      heard.device = io::recognise(first.view());
      if (heard.device == nullptr) continue;
      heard.baud = baud;
      return heard;
    }
  }
  return heard;
}

}  // namespace nacelle::doctor
