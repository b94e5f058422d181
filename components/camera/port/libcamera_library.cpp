// SPDX-License-Identifier: Apache-2.0
// The entry of nacelle/ports/libcamera.so.
#include <memory>

#include "camera/port/libcamera_capture.hpp"
#include "camera/port/port_library.hpp"

namespace nacelle::camera {
namespace {

CapturePort* make_port(const Clock& clock) { return std::make_unique<LibcameraCapture>(clock).release(); }

}  // namespace
}  // namespace nacelle::camera

extern "C" __attribute__((visibility("default"))) const nacelle::camera::PortEntry* nacelle_capture_port();
const nacelle::camera::PortEntry* nacelle_capture_port() {
  static const nacelle::camera::PortEntry entry{nacelle::camera::kPortAbi, &nacelle::camera::make_port};
  return &entry;
}
