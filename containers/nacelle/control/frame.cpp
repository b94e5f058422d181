// SPDX-License-Identifier: Apache-2.0
#include "control/frame.hpp"

namespace nacelle::control {

bool is_known(FrameKind kind) {
  switch (kind) {
    case FrameKind::Request:
    case FrameKind::Reply:
    case FrameKind::Item:
    case FrameKind::OpenWriter:
    case FrameKind::Opened:
    case FrameKind::Publish:
    case FrameKind::Lookup:
    case FrameKind::Transform:
    case FrameKind::Stats:
    case FrameKind::Shutdown:
    case FrameKind::Fault: return true;
  }
  return false;
}

const char* to_text(FrameFault fault) {
  switch (fault) {
    case FrameFault::TooLong: return "the frame is longer than this side accepts";
    case FrameFault::UnknownKind: return "the frame's kind is unknown; is the other side of the same version?";
  }
  return "?";
}

}  // namespace nacelle::control
