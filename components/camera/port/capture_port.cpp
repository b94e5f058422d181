// SPDX-License-Identifier: Apache-2.0
#include "camera/port/capture_port.hpp"

namespace nacelle::camera {

const char* to_text(CaptureFault fault) {
  switch (fault) {
    case CaptureFault::NoFrame: return "no frame came";
    case CaptureFault::Broken: return "the driver lost the stream";
    case CaptureFault::Gone: return "the device is gone (cable pulled?)";
  }
  return "unknown";
}

}  // namespace nacelle::camera
